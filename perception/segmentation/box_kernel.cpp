// Compiled once for each kind of processor (Highway), of which the best is taken when it runs. No OpenCV or
// Eigen here: an inline function compiled for another processor must not be the one that the linker keeps.
#include "perception/segmentation/box_kernel.hpp"

#include <cstring>

#define HWY_DISABLED_TARGETS \
  (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)  // no arrays of theirs
#define HWY_TARGET_INCLUDE "perception/segmentation/box_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ballservo {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<std::uint8_t, 64>;
using Bytes = hn::Vec<Tag>;
constexpr int lanes = static_cast<int>(hn::MaxLanes(Tag()));

/// The cells of some pixels, a channel each, and their places in either half of a table.
struct Cells {
  Bytes lower[3], upper[3];

  HWY_INLINE Cells() {}  // GCC would compile its own for another processor
  HWY_INLINE void read(const std::uint8_t* bgr) {
    const Tag tag;
    Bytes channels[3];
    hn::LoadInterleaved3(tag, bgr, channels[0], channels[1], channels[2]);
    for (int c = 0; c < 3; ++c) {
      const Bytes cell = hn::ShiftRight<3>(channels[c]);
      lower[c] = hn::And(cell, hn::Set(tag, 15));
      upper[c] = hn::Sub(cell, hn::Set(tag, 16));  // negative in the lower half: looked up as 0
    }
  }
};

/// Entries 0 to 15 of each channel, and what turns them into entries 16 to 31: a look-up knows 16.
struct Tables {
  Bytes first[3], change[3];

  HWY_INLINE explicit Tables(const BoxTables& tables) {
    const Tag tag;
    for (int c = 0; c < 3; ++c) {
      first[c] = hn::LoadDup128(tag, tables.bits[c]);
      change[c] = hn::Xor(first[c], hn::LoadDup128(tag, tables.bits[c] + 16));
    }
  }
  HWY_INLINE Bytes bits(const Cells& cells) const {
    Bytes all = hn::Set(Tag(), 255);
    for (int c = 0; c < 3; ++c) {
      all = hn::And(all, hn::Xor(hn::TableLookupBytes(first[c], cells.lower[c]),
                                 hn::TableLookupBytesOr0(change[c], cells.upper[c])));
    }
    return all;
  }
};

/// A bit for each of a part of a word's 64 pixels: is it not 0?
HWY_INLINE std::uint64_t bits_of_part(int part, Bytes pixels) {
  const Tag tag;
  std::uint64_t bits = 0;
  hn::StoreMaskBits(tag, hn::Ne(pixels, hn::Zero(tag)), reinterpret_cast<std::uint8_t*>(&bits));
  return bits << (part * lanes);
}

void tell(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes, std::uint64_t* const* rows,
          std::uint64_t* unsure) {
  constexpr int parts = 64 / lanes;
  const Tables outer(boxes.outer), inner(boxes.inner);
  std::uint8_t rest[3 * 64] = {};
  for (int index = 0; 64 * index < pixels; ++index, bgr += 3 * 64) {
    const int count = pixels - 64 * index;
    std::uint64_t counted = ~std::uint64_t{0};
    if (count < 64) {
      std::memcpy(rest, bgr, static_cast<std::size_t>(3 * count));
      bgr = rest;
      counted >>= 64 - count;
    }
    Cells cells[parts];
    std::uint64_t left = 0;
    for (int part = 0; part < parts; ++part) {
      cells[part].read(bgr + 3 * lanes * part);
      left |= bits_of_part(part, outer.bits(cells[part]));
    }
    left &= counted;
    if (left == 0) {
      for (int k = 0; k < boxes.classes; ++k) rows[k][index] = 0;
    } else {
      Bytes in_inner[parts];
      for (int part = 0; part < parts; ++part) in_inner[part] = inner.bits(cells[part]);
      for (int k = 0; k < boxes.classes; ++k) {
        const Bytes own = hn::Set(Tag(), boxes.inner_of_class[k]);
        std::uint64_t sure = 0;
        for (int part = 0; part < parts; ++part) sure |= bits_of_part(part, hn::And(in_inner[part], own));
        rows[k][index] = sure & left;
        left &= ~sure;
      }
    }
    unsure[index] = left;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ballservo
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ballservo {

HWY_EXPORT(tell);

void tell_by_boxes(const std::uint8_t* bgr, int pixels, const ColorBoxes& boxes, std::uint64_t* const* rows,
                   std::uint64_t* unsure) {
  HWY_DYNAMIC_DISPATCH(tell)(bgr, pixels, boxes, rows, unsure);
}

}  // namespace ballservo
#endif
