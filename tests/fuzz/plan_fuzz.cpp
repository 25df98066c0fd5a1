// Plans of comparisons.
#include "app/comparison/pictures/plan.hpp"
#include "calibration/base/fault.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder(BALLSERVO_DATA_DIR);
  try {
    parse_comparison_plan(fuzz::text_of(data, size), "fuzz.yaml", folder.inputs());
  } catch (const InputError&) {
  }
  return 0;
}
