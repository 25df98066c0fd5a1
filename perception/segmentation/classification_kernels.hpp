// The inner loops of the classification, one for each kind of processor. No OpenCV or Eigen here: an inline
// function compiled with another processor's instructions must not be the one that the linker keeps.
#pragma once

#include <cstdint>

namespace ballservo {

/// For each channel (blue, green, red) and each 8 of its levels, in which of eight boxes of colours they lie,
/// a bit for each box: a colour lies in the boxes whose bits all three entries share. The 32 entries stand
/// there twice, for the one who reads 64.
struct BoxTables {
  alignas(64) std::uint8_t bits[3][64] = {};
};

/// What tells the classes of most colours: none outside the outer boxes; in an inner box, the box's.
struct ColorBoxes {
  BoxTables outer, inner;
  int classes = 0;
  std::uint8_t inner_of_class[15] = {};  ///< the bits of each class's inner boxes
};

/// Tells a row's pixels (bytes blue, green, red) by the boxes: pixel i is bit i % 64 of word i / 64, in the
/// row of its class, or in `unsure` where it lies in an outer box alone. Writes all words that the pixels
/// need in every row, with zeros behind the last pixel; reads nothing behind it.
using BoxKernel = void (*)(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                           std::uint64_t* const* rows, std::uint64_t* unsure);

void tell_by_boxes_portable(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                            std::uint64_t* const* rows, std::uint64_t* unsure);
#if defined(__x86_64__)
void tell_by_boxes_avx2(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                        std::uint64_t* const* rows, std::uint64_t* unsure);
void tell_by_boxes_avx512(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                          std::uint64_t* const* rows, std::uint64_t* unsure);
#endif

}  // namespace ballservo
