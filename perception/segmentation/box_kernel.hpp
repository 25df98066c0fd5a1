// The inner loop of the classification.
#pragma once

#include <cstdint>

namespace ballservo {

/// For each channel (blue, green, red) and each 8 of its levels, in which of eight boxes of colours they lie,
/// a bit for each box: a colour lies in the boxes whose bits all three entries share.
struct BoxTables {
  alignas(32) std::uint8_t bits[3][32] = {};
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
void tell_by_boxes(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes, std::uint64_t* const* rows,
                   std::uint64_t* unsure);

}  // namespace ballservo
