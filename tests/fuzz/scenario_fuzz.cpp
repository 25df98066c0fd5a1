// Scenarios; leading lines "#set KEY=VALUE" stand for --set.
#include "app/scenario/scenario.hpp"
#include "calibration/base/fault.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder(BALLSERVO_DATA_DIR);
  const std::string text = fuzz::text_of(data, size);
  std::vector<std::string> sets;
  for (std::size_t at = 0; text.compare(at, 5, "#set ") == 0;) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    sets.push_back(text.substr(at + 5, end - at - 5));
    at = std::min(end + 1, text.size());
  }
  try {
    load_scenario(folder.file("scenario.yaml", text), sets, 1);
  } catch (const InputError&) {
  }
  return 0;
}
