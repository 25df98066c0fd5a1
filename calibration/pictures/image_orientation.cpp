#include "calibration/pictures/image_orientation.hpp"

#include <opencv2/imgproc.hpp>

#include "calibration/base/bytes.hpp"

namespace ballservo {
namespace {

using namespace std::string_view_literals;

constexpr std::uint32_t orientation_tag = 0x0112;

/// Tag 0x0112 of the first directory of a TIFF structure, as EXIF holds it.
int orientation_in_tiff(std::string_view tiff) {
  const std::string_view order = tiff.substr(0, 4);
  if (order != "II*\0"sv && order != "MM\0*"sv) return 1;
  const Bytes in(tiff);
  const bool big = tiff[0] == 'M';
  const auto directory = in.number(4, 4, big);
  const auto count = directory ? in.number(*directory, 2, big) : std::nullopt;
  for (std::size_t i = 0; count && i < *count; ++i) {
    const std::size_t entry = std::size_t{*directory} + 2 + 12 * i;
    const auto tag = in.number(entry, 2, big), type = in.number(entry + 2, 2, big);
    if (!tag || !type) return 1;
    if (*tag != orientation_tag) continue;
    const auto value = in.number(entry + 8, 2, big);
    return *type == 3 && value && *value >= 1 && *value <= 8 ? static_cast<int>(*value) : 1;
  }
  return 1;
}

/// The first APP1 segment that is EXIF, before the frame header (T.81, B.2.2; EXIF 2.32, 4.7.2).
int orientation_in_jpeg(std::string_view bytes) {
  const Bytes in(bytes);
  std::size_t at = 2;
  while (in.u8(at) == 0xFFu) {
    const auto marker = in.u8(at + 1);
    if (!marker) return 1;
    if (*marker == 0xFF) {  // padding before a marker
      ++at;
      continue;
    }
    const auto length = in.big16(at + 2);
    const bool table = *marker == 0xC4 || *marker == 0xCC || (*marker >= 0xDB && *marker <= 0xFE);
    if (!table || !length || *length < 2 || bytes.size() - at < 2 + *length) return 1;
    const std::string_view segment = bytes.substr(at + 4, *length - 2);
    if (*marker == 0xE1 && segment.substr(0, 6) == "Exif\0\0"sv)
      return orientation_in_tiff(segment.substr(6));
    at += 2 + *length;
  }
  return 1;
}

/// The chunk of that type among PNG's or RIFF's chunks; empty if there is none before the end of the bytes.
std::string_view chunk(std::string_view bytes, std::size_t at, std::string_view type, bool png) {
  const Bytes in(bytes);
  while (true) {
    const auto length = png ? in.big32(at) : in.little32(at + 4);
    if (!length || bytes.size() - at < 8 || bytes.size() - at - 8 < *length) return {};
    if (bytes.substr(at + (png ? 4 : 0), 4) == type) return bytes.substr(at + 8, *length);
    at += 8 + std::size_t{*length} + (png ? 4 : *length % 2);  // PNG's checksum, or RIFF's padding
  }
}

}  // namespace

int image_orientation_from_header(std::string_view bytes) {
  if (bytes.substr(0, 3) == "\xFF\xD8\xFF"sv) return orientation_in_jpeg(bytes);
  if (bytes.substr(0, 8) == "\x89PNG\r\n\x1A\n"sv) return orientation_in_tiff(chunk(bytes, 8, "eXIf", true));
  if (bytes.substr(0, 4) != "RIFF"sv || bytes.size() < 12 || bytes.substr(8, 4) != "WEBP"sv) return 1;
  std::string_view exif = chunk(bytes, 12, "EXIF", false);
  if (exif.substr(0, 6) == "Exif\0\0"sv) exif.remove_prefix(6);
  return orientation_in_tiff(exif);
}

cv::Mat upright(const cv::Mat& image, int orientation) {
  cv::Mat result;
  if (image.empty()) return image;
  switch (orientation) {
    case 2:
      cv::flip(image, result, 1);
      return result;
    case 3:
      cv::rotate(image, result, cv::ROTATE_180);
      return result;
    case 4:
      cv::flip(image, result, 0);
      return result;
    case 5:
      cv::transpose(image, result);
      return result;
    case 6:
      cv::rotate(image, result, cv::ROTATE_90_CLOCKWISE);
      return result;
    case 7:
      cv::rotate(image, result, cv::ROTATE_180);
      cv::transpose(result, result);
      return result;
    case 8:
      cv::rotate(image, result, cv::ROTATE_90_COUNTERCLOCKWISE);
      return result;
    default:
      return image;
  }
}

}  // namespace ballservo
