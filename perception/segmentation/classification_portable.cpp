#include <algorithm>

#include "perception/segmentation/classification_kernels.hpp"

namespace ballservo {
namespace {

unsigned bits_of(const BoxTables& tables, const std::uint8_t* p) {
  return tables.bits[0][p[0] >> 3] & tables.bits[1][p[1] >> 3] & tables.bits[2][p[2] >> 3];
}

}  // namespace

void tell_by_boxes_portable(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes,
                            std::uint64_t* const* rows, std::uint64_t* unsure) {
  for (int word = 0; 64 * word < pixels; ++word, bgr += 3 * 64) {
    const int count = std::min(pixels - 64 * word, 64);
    std::uint64_t outer = 0;
    for (int i = 0; i < count; ++i)
      outer |= static_cast<std::uint64_t>(bits_of(boxes.outer, bgr + 3 * i) != 0) << i;
    for (int k = 0; k < boxes.classes; ++k) rows[k][word] = 0;
    unsure[word] = outer;
    for (; outer != 0; outer &= outer - 1) {
      const unsigned inner = bits_of(boxes.inner, bgr + 3 * __builtin_ctzll(outer));
      if (inner == 0) continue;
      const std::uint64_t pixel = outer & (0 - outer);
      unsure[word] ^= pixel;
      int k = 0;
      while ((inner & boxes.inner_of_class[k]) == 0) ++k;
      rows[k][word] |= pixel;
    }
  }
}

}  // namespace ballservo
