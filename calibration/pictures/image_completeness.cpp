#include "calibration/pictures/image_completeness.hpp"

#include <cstdint>

#include "calibration/pictures/image_file.hpp"

namespace ballservo {
namespace {

unsigned byte_at(std::string_view bytes, std::size_t at) { return static_cast<unsigned char>(bytes[at]); }

std::uint64_t little32(std::string_view bytes, std::size_t at) {
  return byte_at(bytes, at) | byte_at(bytes, at + 1) << 8 | byte_at(bytes, at + 2) << 16 |
         static_cast<std::uint64_t>(byte_at(bytes, at + 3)) << 24;
}

bool png_is_complete(std::string_view bytes) {
  std::size_t at = 8;
  while (bytes.size() - at >= 12) {  // length, type and checksum of a chunk
    const std::uint64_t length = static_cast<std::uint64_t>(byte_at(bytes, at)) << 24 |
                                 byte_at(bytes, at + 1) << 16 | byte_at(bytes, at + 2) << 8 |
                                 byte_at(bytes, at + 3);
    if (length > bytes.size() - at - 12) return false;
    if (bytes.substr(at + 4, 4) == "IEND") return true;
    at += 12 + static_cast<std::size_t>(length);
  }
  return false;
}

/// The segments are walked rather than searched: an embedded thumbnail ends with a marker of its own. Bytes
/// after the end marker are allowed, as cameras append them.
bool jpeg_is_complete(std::string_view bytes) {
  std::size_t at = 2;
  bool in_scan = false;
  while (at + 1 < bytes.size()) {
    const unsigned first = byte_at(bytes, at), marker = byte_at(bytes, at + 1);
    if (first != 0xFF) {
      if (!in_scan) return false;
      ++at;
    } else if (marker == 0xFF) {
      ++at;
    } else if (marker == 0x00 || (marker >= 0xD0 && marker <= 0xD7)) {  // a stuffed byte, or a restart
      at += 2;
    } else if (marker == 0xD9) {
      return true;
    } else {
      if (at + 3 >= bytes.size()) return false;
      at += 2 + (byte_at(bytes, at + 2) << 8 | byte_at(bytes, at + 3));
      in_scan = marker == 0xDA;
    }
  }
  return false;
}

/// Only the uncompressed kinds have a size known beforehand.
bool bmp_is_complete(std::string_view bytes, const ImageSize& size) {
  if (bytes.size() < 26) return false;
  const bool old_header = little32(bytes, 14) == 12;
  if (bytes.size() < (old_header ? 26u : 54u)) return false;
  const std::size_t bits_at = old_header ? 24 : 28;
  const std::uint64_t bits = byte_at(bytes, bits_at) | byte_at(bytes, bits_at + 1) << 8;
  const std::uint64_t compression = old_header ? 0 : little32(bytes, 30);
  if (compression == 1 || compression == 2) return true;
  if (bits > 32) return false;
  const std::uint64_t row_bytes = (bits * static_cast<std::uint64_t>(size.width_px) + 31) / 32 * 4;
  const std::uint64_t pixels_at = little32(bytes, 10);
  return pixels_at <= bytes.size() && row_bytes <= bytes.size() &&
         row_bytes * static_cast<std::uint64_t>(size.height_px) <= bytes.size() - pixels_at;
}

/// A lower bound that leaves out the header's few bytes.
bool pnm_is_complete(std::string_view bytes, const ImageSize& size) {
  const auto width = static_cast<std::uint64_t>(size.width_px),
             height = static_cast<std::uint64_t>(size.height_px);
  switch (bytes[1]) {
    case '4':
      return (width + 7) / 8 * height < bytes.size();
    case '5':
      return width * height < bytes.size();
    case '6':
      return 3 * width * height < bytes.size();
    default:
      return width * height < bytes.size();  // as digits, at least one a pixel
  }
}

}  // namespace

bool image_is_complete(std::string_view bytes) {
  const auto size = image_size_from_header(bytes);
  if (!size) return false;
  switch (bytes[0]) {
    case '\x89':
      return png_is_complete(bytes);
    case '\xFF':
      return jpeg_is_complete(bytes);
    case 'B':
      return bmp_is_complete(bytes, *size);
    case 'P':
      return pnm_is_complete(bytes, *size);
    case 'R':
      return little32(bytes, 4) <= bytes.size() - 8;
    default:
      return true;
  }
}

}  // namespace ballservo
