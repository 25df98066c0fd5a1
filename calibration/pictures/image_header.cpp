// What the containers say: PNG (ISO 15948), JPEG (ITU-T T.81), BMP, PNM, TIFF 6.0, WebP (RFC 9649),
// EXIF 2.32. The bytes are hostile: every read is checked against their end.
#include "calibration/pictures/image_header.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <limits>

namespace ballservo {
namespace {

using namespace std::string_view_literals;
using Number = std::optional<std::uint32_t>;

/// The unsigned number of some bytes at an offset, or nothing beyond the end.
Number number(std::string_view bytes, std::size_t offset, std::size_t length, bool big_endian) {
  if (offset > bytes.size() || bytes.size() - offset < length) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < length; ++i) {
    const std::size_t at = big_endian ? i : length - 1 - i;
    value = value << 8 | static_cast<unsigned char>(bytes[offset + at]);
  }
  return value;
}
Number big(std::string_view bytes, std::size_t at, std::size_t length) {
  return number(bytes, at, length, true);
}
Number little(std::string_view bytes, std::size_t at, std::size_t length) {
  return number(bytes, at, length, false);
}

enum class Format { none, png, jpeg, bmp, pnm, tiff, webp };

Format format_of(std::string_view bytes) {
  const auto starts_with = [&](std::string_view magic) { return bytes.substr(0, magic.size()) == magic; };
  if (starts_with("\x89PNG\r\n\x1A\n"sv)) return Format::png;
  if (starts_with("\xFF\xD8\xFF"sv)) return Format::jpeg;
  if (starts_with("BM"sv)) return Format::bmp;
  if (starts_with("II*\0"sv) || starts_with("MM\0*"sv)) return Format::tiff;
  if (starts_with("RIFF"sv) && bytes.size() >= 16 && bytes.substr(8, 4) == "WEBP"sv) return Format::webp;
  if (bytes.size() > 2 && bytes[0] == 'P' && bytes[1] >= '1' && bytes[1] <= '6') return Format::pnm;
  return Format::none;
}

std::optional<ImageSize> checked_size(Number width, Number height) {
  constexpr std::uint32_t limit = std::numeric_limits<std::int32_t>::max();
  if (!width || !height || *width == 0 || *height == 0 || *width > limit || *height > limit)
    return std::nullopt;
  return ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
}

/// The contents of the first chunk of that type, among PNG's chunks or RIFF's; nothing if the bytes end
/// before the end of such a chunk.
std::optional<std::string_view> chunk(std::string_view bytes, std::size_t at, std::string_view type,
                                      bool png) {
  while (true) {
    const std::size_t around = png ? 12 : 8;  // length, type, and PNG's checksum
    const auto length = png ? big(bytes, at, 4) : little(bytes, at + 4, 4);
    if (!length || bytes.size() - at < around || bytes.size() - at - around < *length) return std::nullopt;
    if (bytes.substr(at + (png ? 4 : 0), 4) == type) return bytes.substr(at + 8, *length);
    at += around + std::size_t{*length} + (png ? 0 : *length % 2);  // RIFF's padding
  }
}

/// Calls visit(marker, place of what follows it) for each segment of a JPEG (T.81, B.1.1) until that returns
/// true; false where it never did. The segments are walked rather than searched: an embedded thumbnail has
/// markers of its own.
template <class Visit>
bool visit_jpeg_segments(std::string_view bytes, const Visit& visit) {
  bool in_scan = false;
  for (std::size_t at = 2;;) {
    const auto first = big(bytes, at, 1), marker = big(bytes, at + 1, 1);
    if (!first || !marker || (*first != 0xFF && !in_scan)) return false;
    if (*first != 0xFF || *marker == 0xFF) {  // coded pixels, or padding before a marker
      ++at;
    } else if (in_scan && (*marker == 0 || (*marker >= 0xD0 && *marker <= 0xD7))) {
      at += 2;  // a stuffed byte, or a restart
    } else if (visit(*marker, at + 2)) {
      return true;
    } else {
      const auto length = big(bytes, at + 2, 2);
      if (!length || *length < 2) return false;
      at += 2 + *length;
      in_scan = *marker == 0xDA;
    }
  }
}

bool ends_jpeg_header(std::uint32_t marker) {
  const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
  return frame || marker < 0xC0 || (marker >= 0xD0 && marker <= 0xDA);
}

std::optional<ImageSize> jpeg_size(std::string_view bytes) {
  std::optional<ImageSize> size;
  visit_jpeg_segments(bytes, [&](std::uint32_t marker, std::size_t at) {
    if (!ends_jpeg_header(marker)) return false;
    if (marker >= 0xC0 && marker <= 0xCF) size = checked_size(big(bytes, at + 5, 2), big(bytes, at + 3, 2));
    return true;
  });
  return size;
}

/// Of the frame header's components (T.81, B.2.2): does the second have fewer samples than the first?
bool jpeg_has_coarse_chroma(std::string_view bytes) {
  bool coarse = false;
  visit_jpeg_segments(bytes, [&](std::uint32_t marker, std::size_t at) {
    if (!ends_jpeg_header(marker)) return false;
    const auto components = big(bytes, at + 7, 1), luma = big(bytes, at + 9, 1),
               chroma = big(bytes, at + 12, 1);
    coarse = marker >= 0xC0 && marker <= 0xCF && components == 3u && luma && chroma &&
             (*luma >> 4 > *chroma >> 4 || (*luma & 15) > (*chroma & 15));
    return true;
  });
  return coarse;
}

std::optional<ImageSize> bmp_size(std::string_view bytes) {
  const auto header = little(bytes, 14, 4);
  if (!header) return std::nullopt;
  if (*header == 12) return checked_size(little(bytes, 18, 2), little(bytes, 20, 2));
  if (*header < 40) return std::nullopt;
  auto height = little(bytes, 22, 4);
  if (height && *height > 0x80000000u) height = ~*height + 1;  // negative: rows from the top down
  return checked_size(little(bytes, 18, 4), height);
}

std::optional<ImageSize> pnm_size(std::string_view bytes) {
  std::size_t at = 2;
  const auto next_number = [&]() -> Number {
    const auto blank = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
    const std::size_t start = at;
    while (at < bytes.size() && (blank(bytes[at]) || bytes[at] == '#')) {
      at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
    }
    if (at == start) return std::nullopt;
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), value);
    if (error != std::errc()) return std::nullopt;
    at = static_cast<std::size_t>(end - bytes.data());
    return value;
  };
  const auto width = next_number();
  const auto height = width ? next_number() : std::nullopt;
  return checked_size(width, height);
}

/// Calls visit(tag, type, count, place of the value) for each entry of the first directory of a TIFF
/// structure until that returns true; false where the directory is damaged before.
template <class Visit>
bool visit_tiff_entries(std::string_view tiff, const Visit& visit) {
  if (format_of(tiff) != Format::tiff) return false;
  const bool big_endian = tiff[0] == 'M';
  const auto directory = number(tiff, 4, 4, big_endian);
  const auto entries = directory ? number(tiff, *directory, 2, big_endian) : std::nullopt;
  if (!entries) return false;
  for (std::size_t i = 0; i < *entries; ++i) {
    const std::size_t entry = std::size_t{*directory} + 2 + 12 * i;
    const auto tag = number(tiff, entry, 2, big_endian), type = number(tiff, entry + 2, 2, big_endian),
               count = number(tiff, entry + 4, 4, big_endian);
    if (!tag || !type || !count) return false;
    if (visit(*tag, *type, *count, entry + 8)) return true;
  }
  return true;
}

std::optional<ImageSize> tiff_size(std::string_view bytes) {
  constexpr std::uint32_t width_tag = 256, height_tag = 257, short_type = 3, long_type = 4;
  Number width, height;
  const bool whole = visit_tiff_entries(
      bytes, [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::size_t at) {
        const bool one_number = (type == short_type || type == long_type) && count == 1;
        if (tag == width_tag || tag == height_tag)
          (tag == width_tag ? width : height) =
              one_number ? number(bytes, at, type == short_type ? 2 : 4, bytes[0] == 'M') : std::nullopt;
        return false;
      });
  return whole ? checked_size(width, height) : std::nullopt;
}

std::optional<ImageSize> webp_size(std::string_view bytes) {
  const std::string_view kind = bytes.substr(12, 4);
  if (kind == "VP8X") {
    const auto width = little(bytes, 24, 3), height = little(bytes, 27, 3);
    if (width && height) return checked_size(*width + 1, *height + 1);
  } else if (kind == "VP8L") {
    const auto bits = little(bytes, 21, 4);
    if (big(bytes, 20, 1) == 0x2Fu && bits)
      return checked_size((*bits & 0x3FFF) + 1, (*bits >> 14 & 0x3FFF) + 1);
  } else if (kind == "VP8 ") {
    const auto width = little(bytes, 26, 2), height = little(bytes, 28, 2);
    if (little(bytes, 23, 3) == 0x2A019Du && width && height)
      return checked_size(*width & 0x3FFF, *height & 0x3FFF);
  }
  return std::nullopt;
}

std::optional<ImageSize> stored_size(std::string_view bytes) {
  switch (format_of(bytes)) {
    case Format::png:
      if (bytes.size() < 24 || bytes.substr(12, 4) != "IHDR") return std::nullopt;
      return checked_size(big(bytes, 16, 4), big(bytes, 20, 4));
    case Format::jpeg:
      return jpeg_size(bytes);
    case Format::bmp:
      return bmp_size(bytes);
    case Format::pnm:
      return pnm_size(bytes);
    case Format::tiff:
      return tiff_size(bytes);
    case Format::webp:
      return webp_size(bytes);
    case Format::none:
      break;
  }
  return std::nullopt;
}

/// Tag 0x0112 of the first directory of a TIFF structure, as EXIF holds it.
int orientation_in_tiff(std::string_view tiff) {
  int orientation = 1;
  visit_tiff_entries(tiff, [&](std::uint32_t tag, std::uint32_t type, std::uint32_t, std::size_t at) {
    if (tag != 0x0112) return false;
    const auto value = number(tiff, at, 2, tiff[0] == 'M');
    if (type == 3 && value && *value >= 1 && *value <= 8) orientation = static_cast<int>(*value);
    return true;
  });
  return orientation;
}

/// Of the first APP1 segment that is EXIF, before the frame header (T.81, B.2.2; EXIF 2.32, 4.7.2).
int orientation_in_jpeg(std::string_view bytes) {
  int orientation = 1;
  visit_jpeg_segments(bytes, [&](std::uint32_t marker, std::size_t at) {
    if (ends_jpeg_header(marker)) return true;
    const auto length = big(bytes, at, 2);
    if (!length || *length < 2 || bytes.size() - at < *length) return true;
    const std::string_view segment = bytes.substr(at + 2, *length - 2);
    if (marker != 0xE1 || segment.substr(0, 6) != "Exif\0\0"sv) return false;
    orientation = orientation_in_tiff(segment.substr(6));
    return true;
  });
  return orientation;
}

/// Only the uncompressed kinds have a size known beforehand.
bool bmp_is_complete(std::string_view bytes, const ImageSize& size) {
  const bool old_header = little(bytes, 14, 4) == 12u;
  if (bytes.size() < (old_header ? 26u : 54u)) return false;
  const std::uint64_t bits = *little(bytes, old_header ? 24 : 28, 2), pixels_at = *little(bytes, 10, 4);
  const std::uint32_t compression = old_header ? 0 : *little(bytes, 30, 4);
  if (compression == 1 || compression == 2) return true;
  if (bits > 32) return false;
  const std::uint64_t row_bytes = (bits * static_cast<std::uint64_t>(size.width_px) + 31) / 32 * 4;
  return pixels_at <= bytes.size() && row_bytes <= bytes.size() &&
         row_bytes * static_cast<std::uint64_t>(size.height_px) <= bytes.size() - pixels_at;
}

/// A lower bound that leaves out the header's few bytes.
bool pnm_is_complete(std::string_view bytes, const ImageSize& size) {
  const auto width = static_cast<std::uint64_t>(size.width_px),
             height = static_cast<std::uint64_t>(size.height_px);
  const std::uint64_t bytes_a_row = bytes[1] == '4'   ? (width + 7) / 8
                                    : bytes[1] == '6' ? 3 * width
                                                      : width;  // as digits, at least one a pixel
  return bytes_a_row * height < bytes.size();
}

}  // namespace

std::optional<ImageSize> image_size_from_header(std::string_view bytes) {
  const auto stored = stored_size(bytes);
  const bool on_its_side = image_orientation_from_header(bytes) >= 5;
  return stored && on_its_side ? ImageSize{stored->height_px, stored->width_px} : stored;
}

int image_orientation_from_header(std::string_view bytes) {
  switch (format_of(bytes)) {
    case Format::jpeg:
      return orientation_in_jpeg(bytes);
    case Format::png:
      return orientation_in_tiff(chunk(bytes, 8, "eXIf", true).value_or(""));
    case Format::webp: {
      std::string_view exif = chunk(bytes, 12, "EXIF", false).value_or("");
      if (exif.substr(0, 6) == "Exif\0\0"sv) exif.remove_prefix(6);
      return orientation_in_tiff(exif);
    }
    default:
      return 1;
  }
}

bool has_coarse_chroma(std::string_view bytes) {
  const Format format = format_of(bytes);
  return format == Format::jpeg ? jpeg_has_coarse_chroma(bytes)
                                : format == Format::webp && bytes.substr(12, 4) == "VP8 ";
}

bool image_is_complete(std::string_view bytes) {
  const auto size = stored_size(bytes);
  if (!size) return false;
  switch (format_of(bytes)) {
    case Format::png:
      return chunk(bytes, 8, "IEND", true).has_value();
    case Format::jpeg:  // bytes after the end marker are allowed, as cameras append them
      return visit_jpeg_segments(bytes, [](std::uint32_t marker, std::size_t) { return marker == 0xD9; });
    case Format::bmp:
      return bmp_is_complete(bytes, *size);
    case Format::pnm:
      return pnm_is_complete(bytes, *size);
    case Format::webp:
      return *little(bytes, 4, 4) <= bytes.size() - 8;
    default:
      return true;
  }
}

}  // namespace ballservo
