// What a picture's file says of it before anything is decoded.
#pragma once

#include <optional>
#include <string_view>

#include "calibration/base/image_size.hpp"

namespace ballservo {

/// The upright picture's size (EXIF orientation applied) from the first bytes of a PNG, JPEG, BMP, PNM, TIFF
/// or WebP file; nothing if it is none of these or the header is damaged.
std::optional<ImageSize> image_size_from_header(std::string_view bytes);

/// The orientation tag (1 to 8, EXIF 2.32, 4.6.4) of the first bytes of a JPEG, PNG or WebP file; 1, upright,
/// where there is none or it is damaged.
int image_orientation_from_header(std::string_view bytes);

/// Whether colours are stored at a lower resolution than brightness, by the first bytes: most JPEG files,
/// lossy WebP. False where they do not tell.
bool has_coarse_chroma(std::string_view bytes);

/// Whether an image file goes on to its end: decoders fill what is missing with grey and say nothing. False
/// if the bytes stop before: no IEND chunk (PNG), no EOI marker after the scans (JPEG), fewer bytes than the
/// header promises (BMP, PNM, WebP). True where the format does not tell before decoding.
bool image_is_complete(std::string_view bytes);

}  // namespace ballservo
