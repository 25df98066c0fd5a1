// Sizes from picture headers, and whether a picture's file goes on to its end.
#include "calibration/pictures/image_header.hpp"
#include "tests/fuzz/fuzz_folder.hpp"

using namespace ballservo;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = fuzz::text_of(data, size);
  if (const auto found = image_size_from_header(bytes))
    fuzz::require(found->width_px > 0 && found->height_px > 0, "a size above 0");
  image_is_complete(bytes);
  return 0;
}
