// Pictures from files, with their size known from the header before anything is decoded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "calibration/base/image_size.hpp"

namespace ballservo {

inline constexpr double default_max_pixels = 32e6;

/// The upright picture's size (EXIF orientation applied) from the first bytes of a PNG, JPEG, BMP, PNM, TIFF
/// or WebP file; nothing if it is none of these or the header is damaged.
std::optional<ImageSize> image_size_from_header(std::string_view bytes);

/// Reads a picture as 8-bit BGR, upright: grey is spread over the channels, 16 bits are scaled to 8, alpha is
/// dropped, EXIF orientation is applied, so that pixels are where a viewer shows them.
/// Throws InputError for a missing, empty, truncated, non-image or too large file.
cv::Mat read_color_image(const std::filesystem::path& file, double max_pixels = default_max_pixels);

/// Encodes by the file name's extension and writes the bytes at `file` (an ordinary write into a staging
/// folder).
void write_image(const std::filesystem::path& file, const cv::Mat& image);

}  // namespace ballservo
