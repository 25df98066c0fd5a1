#include "perception/morphology.hpp"

#include <algorithm>

namespace ballservo {
namespace {

// What lies outside the picture changes nothing in either.
struct Erosion {
  static constexpr std::uint64_t outside = ~std::uint64_t{0};
  static std::uint64_t join(std::uint64_t a, std::uint64_t b) { return a & b; }
};
struct Dilation {
  static constexpr std::uint64_t outside = 0;
  static std::uint64_t join(std::uint64_t a, std::uint64_t b) { return a | b; }
};

// A word joined with its pixels' neighbours up to `reach` to the left and right.
template <class Operation, int reach>
std::uint64_t with_neighbors(std::uint64_t before, std::uint64_t here, std::uint64_t after) {
  std::uint64_t joined = here;
  for (int i = 1; i <= reach; ++i) {
    const std::uint64_t left = here << i | before >> (BitPicture::word_bits - i);
    const std::uint64_t right = here >> i | after << (BitPicture::word_bits - i);
    joined = Operation::join(joined, Operation::join(left, right));
  }
  return joined;
}

template <class Operation, int reach>
void along_row(const std::uint64_t* in, int words, std::uint64_t last_bits, std::uint64_t* out) {
  const std::uint64_t last = (in[words - 1] & last_bits) | (Operation::outside & ~last_bits);
  if (words == 1) {
    out[0] = with_neighbors<Operation, reach>(Operation::outside, last, Operation::outside);
    return;
  }
  for (int w = 1; w < words - 2; ++w) out[w] = with_neighbors<Operation, reach>(in[w - 1], in[w], in[w + 1]);
  const std::uint64_t second = words == 2 ? last : in[1];
  out[0] = with_neighbors<Operation, reach>(Operation::outside, in[0], second);
  if (words > 2) out[words - 2] = with_neighbors<Operation, reach>(in[words - 3], in[words - 2], last);
  out[words - 1] = with_neighbors<Operation, reach>(in[words - 2], last, Operation::outside);
}

// Every pixel joined with the square of `reach` around it. `rows` is room for the first step.
template <class Operation, int reach>
void squares(const BitPicture& in, BitPicture& rows, BitPicture& out) {
  const int height = in.size().height, words = in.row_words();
  rows.resize(in.size());
  out.resize(in.size());
  for (int v = 0; v < height; ++v)
    along_row<Operation, reach>(in.row(v), words, in.last_word_bits(), rows.row(v));
  for (int v = 0; v < height; ++v) {
    std::uint64_t* const to = out.row(v);
    std::copy_n(rows.row(v), words, to);
    for (int other = std::max(0, v - reach); other <= std::min(height - 1, v + reach); ++other) {
      const std::uint64_t* const from = rows.row(other);
      for (int w = 0; w < words; ++w) to[w] = Operation::join(to[w], from[w]);
    }
    to[words - 1] &= in.last_word_bits();
  }
}

template <class Change>
void for_each_word(const BitPicture& picture, const Change& change) {
  for (int v = 0; v < picture.size().height; ++v) {
    for (int w = 0; w < picture.row_words(); ++w) change(v, w);
  }
}

}  // namespace

void ClassMorphology::open(const ClassPictures& classes, ClassPictures& opened) {
  opened.resize(classes.size());
  for (std::size_t k = 0; k < classes.size(); ++k) {
    squares<Erosion, 1>(classes[k], rows_, eroded_);
    squares<Dilation, 1>(eroded_, rows_, opened[k]);
  }
}

void ClassMorphology::close(const ClassPictures& opened, ClassPictures& closed) {
  closed.resize(opened.size());
  for (std::size_t k = 0; k < opened.size(); ++k) {
    squares<Dilation, 2>(opened[k], rows_, dilated_);
    squares<Erosion, 2>(dilated_, rows_, closed[k]);
  }
  if (opened.size() < 2) return;
  // Taken: by a class of its own, or by an earlier class that closed over it.
  taken_ = opened[0];
  for (std::size_t k = 1; k < opened.size(); ++k) {
    for_each_word(taken_, [&](int v, int w) { taken_.row(v)[w] |= opened[k].row(v)[w]; });
  }
  for (std::size_t k = 0; k < opened.size(); ++k) {
    for_each_word(taken_, [&](int v, int w) {
      const std::uint64_t added = closed[k].row(v)[w] & ~taken_.row(v)[w];
      closed[k].row(v)[w] = opened[k].row(v)[w] | added;
      taken_.row(v)[w] |= added;
    });
  }
}

}  // namespace ballservo
