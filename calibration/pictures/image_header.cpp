// Sizes from image headers: PNG (ISO 15948), JPEG (ITU-T T.81), BMP, PNM, TIFF 6.0, WebP (RFC 9649).
// The bytes are hostile: every read is checked against their end.
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "calibration/base/bytes.hpp"
#include "calibration/pictures/image_file.hpp"
#include "calibration/pictures/image_orientation.hpp"

namespace ballservo {
namespace {

bool starts_with(std::string_view bytes, std::string_view magic) {
  return bytes.substr(0, magic.size()) == magic;
}

std::optional<ImageSize> checked_size(std::optional<std::uint32_t> width,
                                      std::optional<std::uint32_t> height) {
  constexpr std::uint32_t limit = std::numeric_limits<std::int32_t>::max();
  if (!width || !height || *width == 0 || *height == 0 || *width > limit || *height > limit)
    return std::nullopt;
  return ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
}

std::optional<ImageSize> png_size(std::string_view bytes) {
  if (bytes.size() < 24 || bytes.substr(12, 4) != "IHDR") return std::nullopt;
  const Bytes in(bytes);
  return checked_size(in.big32(16), in.big32(20));
}

/// Walks the segments up to the frame header (T.81, B.2.2).
std::optional<ImageSize> jpeg_size(std::string_view bytes) {
  const Bytes in(bytes);
  std::size_t at = 2;
  while (true) {
    const auto fill = in.u8(at);
    if (!fill || *fill != 0xFF) return std::nullopt;
    const auto marker = in.u8(at + 1);
    if (!marker) return std::nullopt;
    if (*marker == 0xFF) {  // padding before a marker
      ++at;
      continue;
    }
    const auto length = in.big16(at + 2);
    const bool frame =
        *marker >= 0xC0 && *marker <= 0xCF && *marker != 0xC4 && *marker != 0xC8 && *marker != 0xCC;
    if (frame) return checked_size(in.big16(at + 7), in.big16(at + 5));
    const bool before_frame_only = *marker >= 0xC0 && *marker != 0xD8 && *marker != 0xD9 && *marker != 0xDA;
    if (!before_frame_only || !length || *length < 2) return std::nullopt;
    at += 2 + *length;
  }
}

std::optional<ImageSize> bmp_size(std::string_view bytes) {
  const Bytes in(bytes);
  const auto header = in.little32(14);
  if (!header) return std::nullopt;
  if (*header == 12) return checked_size(in.little16(18), in.little16(20));
  if (*header < 40) return std::nullopt;
  auto height = in.little32(22);
  if (height && *height > 0x80000000u) height = ~*height + 1;  // negative: rows from the top down
  return checked_size(in.little32(18), height);
}

std::optional<ImageSize> pnm_size(std::string_view bytes) {
  std::size_t at = 2;
  const auto next_number = [&]() -> std::optional<std::uint32_t> {
    const auto blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    const std::size_t start = at;
    while (at < bytes.size() && (blank(bytes[at]) || bytes[at] == '#')) {
      if (bytes[at] == '#') {
        while (at < bytes.size() && bytes[at] != '\n') ++at;
      } else {
        ++at;
      }
    }
    if (at == start) return std::nullopt;
    std::uint64_t value = 0;
    const std::size_t digits = at;
    while (at < bytes.size() && bytes[at] >= '0' && bytes[at] <= '9') {
      value = value * 10 + static_cast<std::uint64_t>(bytes[at++] - '0');
      if (value > 0xFFFFFFFFu) return std::nullopt;
    }
    if (at == digits) return std::nullopt;
    return static_cast<std::uint32_t>(value);
  };
  const auto width = next_number();
  const auto height = width ? next_number() : std::nullopt;
  return checked_size(width, height);
}

/// Tags 256 (ImageWidth) and 257 (ImageLength) of the first image file directory.
std::optional<ImageSize> tiff_size(std::string_view bytes) {
  const Bytes in(bytes);
  const bool big = bytes[0] == 'M';
  const auto directory = in.number(4, 4, big);
  const auto count = directory ? in.number(*directory, 2, big) : std::nullopt;
  if (!count) return std::nullopt;
  std::optional<std::uint32_t> width, height;
  for (std::size_t i = 0; i < *count; ++i) {
    const std::size_t entry = std::size_t{*directory} + 2 + 12 * i;
    const auto tag = in.number(entry, 2, big), type = in.number(entry + 2, 2, big),
               values = in.number(entry + 4, 4, big);
    if (!tag || !type || !values) return std::nullopt;
    if (*tag != 256 && *tag != 257) continue;
    const bool is_short = *type == 3, is_long = *type == 4;
    if ((!is_short && !is_long) || *values != 1) return std::nullopt;
    (*tag == 256 ? width : height) = in.number(entry + 8, is_short ? 2 : 4, big);
  }
  return checked_size(width, height);
}

std::optional<ImageSize> webp_size(std::string_view bytes) {
  const Bytes in(bytes);
  const std::string_view kind = bytes.substr(12, 4);
  if (kind == "VP8X") {
    const auto width = in.little24(24), height = in.little24(27);
    if (!width || !height) return std::nullopt;
    return checked_size(*width + 1, *height + 1);
  }
  if (kind == "VP8L") {
    const auto bits = in.little32(21);
    if (in.u8(20).value_or(0) != 0x2F || !bits) return std::nullopt;
    return checked_size((*bits & 0x3FFF) + 1, (*bits >> 14 & 0x3FFF) + 1);
  }
  if (kind == "VP8 ") {
    const auto width = in.little16(26), height = in.little16(28);
    if (in.little24(23).value_or(0) != 0x2A019D || !width || !height) return std::nullopt;
    return checked_size(*width & 0x3FFF, *height & 0x3FFF);
  }
  return std::nullopt;
}

std::optional<ImageSize> stored_size(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (starts_with(bytes, "\x89PNG\r\n\x1A\n"sv)) return png_size(bytes);
  if (starts_with(bytes, "\xFF\xD8\xFF"sv)) return jpeg_size(bytes);
  if (starts_with(bytes, "BM"sv)) return bmp_size(bytes);
  if (starts_with(bytes, "II*\0"sv) || starts_with(bytes, "MM\0*"sv)) return tiff_size(bytes);
  if (starts_with(bytes, "RIFF"sv) && bytes.size() >= 16 && bytes.substr(8, 4) == "WEBP")
    return webp_size(bytes);
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return pnm_size(bytes);
  return std::nullopt;
}

}  // namespace

std::optional<ImageSize> image_size_from_header(std::string_view bytes) {
  const auto stored = stored_size(bytes);
  if (!stored || !swaps_sides(image_orientation_from_header(bytes))) return stored;
  return ImageSize{stored->height_px, stored->width_px};
}

}  // namespace ballservo
