// Unsigned numbers in hostile bytes: every read is checked against their end.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace ballservo {

/// Unsigned numbers at an offset, or nothing beyond the end.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::optional<std::uint32_t> u8(std::size_t offset) const { return number(offset, 1, true); }
  std::optional<std::uint32_t> big16(std::size_t offset) const { return number(offset, 2, true); }
  std::optional<std::uint32_t> big32(std::size_t offset) const { return number(offset, 4, true); }
  std::optional<std::uint32_t> little16(std::size_t offset) const { return number(offset, 2, false); }
  std::optional<std::uint32_t> little24(std::size_t offset) const { return number(offset, 3, false); }
  std::optional<std::uint32_t> little32(std::size_t offset) const { return number(offset, 4, false); }

  std::optional<std::uint32_t> number(std::size_t offset, std::size_t length, bool big_endian) const {
    if (offset > bytes_.size() || bytes_.size() - offset < length) return std::nullopt;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < length; ++i) {
      const std::size_t at = big_endian ? i : length - 1 - i;
      value = value << 8 | static_cast<unsigned char>(bytes_[offset + at]);
    }
    return value;
  }

 private:
  std::string_view bytes_;
};

}  // namespace ballservo
