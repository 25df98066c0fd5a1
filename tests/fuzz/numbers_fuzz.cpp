// Numbers as text: what is read is finite and reads back the same; names have one order.
#include <cmath>

#include "calibration/base/numbers.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = fuzz::text_of(data, size);
  if (const auto number = parse_number(text)) {
    fuzz::require(std::isfinite(*number), "a finite number");
    fuzz::require(parse_number(number_text(*number)) == number, "a number that reads back the same");
  }
  if (const auto integer = parse_integer(text))
    fuzz::require(parse_integer(std::to_string(*integer)) == integer, "an integer that reads back the same");
  const std::string a = text.substr(0, size / 2), b = text.substr(size / 2);
  fuzz::require(!natural_less(a, a) && !(natural_less(a, b) && natural_less(b, a)), "one order of names");
  return 0;
}
