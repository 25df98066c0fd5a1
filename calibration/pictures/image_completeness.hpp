// Whether an image file goes on to its end: decoders fill what is missing with grey and say nothing.
#pragma once

#include <string_view>

namespace ballservo {

/// False if the bytes stop before the picture's end: no IEND chunk (PNG), no EOI marker after the scans
/// (JPEG), fewer bytes than the header promises (BMP, binary PNM, WebP). True where the format does not tell
/// before decoding.
bool image_is_complete(std::string_view bytes);

}  // namespace ballservo
