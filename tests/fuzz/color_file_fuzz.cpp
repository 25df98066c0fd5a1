// Colours files: with a right checksum put before them, so that what lies behind it is reached, and as they
// are.
#include <fmt/format.h>

#include "calibration/base/checksum.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

namespace {

void parse(const std::string& bytes) {
  try {
    const ColorTable table = parse_color_file(bytes, "fuzz.colors");
    fuzz::require(
        color_file_bytes(parse_color_file(color_file_bytes(table), "again")) == color_file_bytes(table),
        "a table that reads back as it was written");
  } catch (const InputError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::text_of(data, size);
  parse(text);
  parse(fmt::format("ballservo colors\nversion {}\nsha256 {}\n", color_file_version, sha256_hex(text)) +
        text);
  return 0;
}
