// The classification's inner loop against its definition: a program without libraries, for a processor that
// an emulator stands for.
#include <cstdio>
#include <random>
#include <vector>

#include "perception/segmentation/box_kernel.hpp"

namespace {

using ballservo::BoxTables;
using ballservo::ColorBoxes;

unsigned boxes_of(const BoxTables& tables, const std::uint8_t* bgr) {
  return tables.bits[0][bgr[0] / 8] & tables.bits[1][bgr[1] / 8] & tables.bits[2][bgr[2] / 8];
}

int class_of(const ColorBoxes& boxes, unsigned inner) {
  for (int k = 0; k < boxes.classes; ++k) {
    if (inner & boxes.inner_of_class[k]) return k;
  }
  return -1;
}

/// Every inner box lies in the outer box of the same bit.
ColorBoxes some_boxes(std::mt19937& engine) {
  ColorBoxes boxes;
  boxes.classes = 3;
  for (int bit = 0; bit < 8; ++bit) boxes.inner_of_class[bit % 3] |= static_cast<std::uint8_t>(1 << bit);
  for (int c = 0; c < 3; ++c) {
    for (int cell = 0; cell < 32; ++cell) {
      boxes.inner.bits[c][cell] = static_cast<std::uint8_t>(engine() & engine());
      boxes.outer.bits[c][cell] = static_cast<std::uint8_t>(boxes.inner.bits[c][cell] | engine());
    }
  }
  return boxes;
}

long wrong_pixels(const ColorBoxes& boxes, int pixels, std::mt19937& engine) {
  std::vector<std::uint8_t> bgr(static_cast<std::size_t>(3 * pixels));  // memory ends where the row does
  for (std::uint8_t& level : bgr) level = static_cast<std::uint8_t>(engine());
  const int words = (pixels + 63) / 64;
  std::vector<std::vector<std::uint64_t>> found(4, std::vector<std::uint64_t>(words, ~std::uint64_t{0}));
  std::uint64_t* const rows[] = {found[0].data(), found[1].data(), found[2].data()};
  ballservo::tell_by_boxes(bgr.data(), pixels, boxes, rows, found[3].data());
  long wrong = 0;
  for (int i = 0; i < 64 * words; ++i) {
    const bool counts = i < pixels;
    const int own = counts ? class_of(boxes, boxes_of(boxes.inner, &bgr[3 * i])) : -1;
    const bool unsure = counts && own < 0 && boxes_of(boxes.outer, &bgr[3 * i]) != 0;
    for (int k = 0; k < 4; ++k) wrong += (found[k][i / 64] >> (i % 64) & 1) != (k < 3 ? own == k : unsure);
  }
  return wrong;
}

}  // namespace

int main() {
  std::mt19937 engine(1);
  long wrong = 0;
  for (int pixels = 1; pixels < 1000; ++pixels) wrong += wrong_pixels(some_boxes(engine), pixels, engine);
  std::printf("%ld pixels told wrongly\n", wrong);
  return wrong > 0;
}
