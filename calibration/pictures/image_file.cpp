#include "calibration/pictures/image_file.hpp"

#include <fmt/format.h>

#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"
#include "calibration/pictures/jpeg_data.hpp"

namespace ballservo {
namespace {

constexpr std::size_t max_image_file_bytes = std::size_t{1} << 30;
constexpr const char* readable_image = "a whole PNG, JPEG, BMP, PNM, TIFF or WebP picture";

/// The pixels as they are stored, or an empty picture if the decoder gave up. Orientation is ours to apply:
/// which decoders do so differs between versions of OpenCV.
cv::Mat decoded(const std::string& bytes) {
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  try {
    return cv::imdecode(buffer, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace

StoredImage read_stored_image(const std::filesystem::path& file, double max_pixels) {
  const std::string place = file.string();
  const std::string bytes = read_file_bytes(file, max_image_file_bytes);
  if (bytes.empty()) throw InputError(place, "an empty file", readable_image);
  const auto size = image_size_from_header(bytes);
  if (!size) throw InputError(place, "bytes that are no picture, or a damaged header", readable_image);
  if (!(static_cast<double>(size->width_px) * size->height_px <= max_pixels)) {
    throw InputError(place, fmt::format("a picture of {} x {} pixels", size->width_px, size->height_px),
                     fmt::format("at most {:.0f} pixels (--max-pixels sets the limit)", max_pixels));
  }
  const bool jpeg = bytes.compare(0, 2, "\xFF\xD8") == 0;
  if (!image_is_complete(bytes) || (jpeg && !jpeg_data_suffice(bytes)))
    throw InputError(place, "a truncated picture", readable_image);
  const cv::Mat image = upright(decoded(bytes), image_orientation_from_header(bytes));
  if (image.type() != CV_8UC3 || image.cols != size->width_px || image.rows != size->height_px) {
    throw InputError(place, "a damaged picture", readable_image);
  }
  return {image, has_coarse_chroma(bytes)};
}

cv::Mat upright(const cv::Mat& image, int orientation) {
  if (image.empty() || orientation < 2 || orientation > 8) return image;
  cv::Mat result = image;
  if (orientation >= 5) cv::transpose(image, result);
  // Left to right, top to bottom, or both (cv::flip's 1, 0, -1).
  constexpr int flips[] = {1, -1, 0, 2, 1, -1, 0};
  const int flip = flips[orientation - 2];
  if (flip == 2) return result;
  cv::Mat flipped;
  cv::flip(result, flipped, flip);
  return flipped;
}

}  // namespace ballservo
