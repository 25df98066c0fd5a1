// Pictures from files.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>

#include "calibration/pictures/image_header.hpp"

namespace ballservo {

inline constexpr double default_max_pixels = 32e6;

struct StoredImage {
  cv::Mat bgr;
  bool coarse_chroma = false;  ///< see has_coarse_chroma
};

/// Reads a picture as 8-bit BGR, upright: grey is spread over the channels, 16 bits are scaled to 8, alpha is
/// dropped, EXIF orientation is applied, so that pixels are where a viewer shows them.
/// Throws InputError for a missing, empty, truncated, non-image or too large file.
StoredImage read_stored_image(const std::filesystem::path& file, double max_pixels = default_max_pixels);
inline cv::Mat read_color_image(const std::filesystem::path& file, double max_pixels = default_max_pixels) {
  return read_stored_image(file, max_pixels).bgr;
}

/// The picture as it is to be shown, by its EXIF orientation (1 to 8).
cv::Mat upright(const cv::Mat& image, int orientation);

}  // namespace ballservo
