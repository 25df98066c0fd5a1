#include "perception/segmentation/morphology.hpp"

#include <algorithm>
#include <functional>

namespace ballservo {
namespace {

// A square is a column of rows: erosion and dilation by it are those across rows and those along rows, in any
// order, so that each opening and closing goes once along the rows. What lies outside the picture changes
// nothing in either.
struct Erosion {
  static constexpr std::uint64_t outside = ~std::uint64_t{0};
  static std::uint64_t join(std::uint64_t a, std::uint64_t b) { return a & b; }
};
struct Dilation {
  static constexpr std::uint64_t outside = 0;
  static std::uint64_t join(std::uint64_t a, std::uint64_t b) { return a | b; }
};

// What follows is compiled twice, inlined into functions with AVX2 and without.

// A word joined with its pixels' neighbours up to `reach` to the left and right.
template <class Operation, int reach>
[[gnu::always_inline]] inline std::uint64_t with_neighbors(std::uint64_t before, std::uint64_t here,
                                                           std::uint64_t after) {
  std::uint64_t joined = here;
  for (int i = 1; i <= reach; ++i) {
    const std::uint64_t left = here << i | before >> (BitPicture::word_bits - i);
    const std::uint64_t right = here >> i | after << (BitPicture::word_bits - i);
    joined = Operation::join(joined, Operation::join(left, right));
  }
  return joined;
}

// Every pixel of the words `first` to `last` joined with its neighbours in the row; beyond it is outside.
template <class Operation, int reach>
[[gnu::always_inline]] inline void along_row(const std::uint64_t* in, int words, int first, int last,
                                             std::uint64_t* out) {
  const auto at = [&](int w) { return w >= 0 && w < words ? in[w] : Operation::outside; };
  const auto join_end = [&](int w) {
    out[w] = with_neighbors<Operation, reach>(at(w - 1), in[w], at(w + 1));
  };
  join_end(first);
  for (int w = first + 1; w < last; ++w)
    out[w] = with_neighbors<Operation, reach>(in[w - 1], in[w], in[w + 1]);
  join_end(last);
}

// Every row of `rows` by one operation and then the other, an opening or a closing; `row` is room for one.
// Words that no set pixel is near to are left alone: there is nothing to change.
template <class First, class Second, int reach>
[[gnu::always_inline]] inline void along_rows(BitPicture& rows, std::vector<std::uint64_t>& row) {
  const int words = rows.row_words();
  const std::uint64_t behind = ~rows.last_word_bits();
  row.resize(static_cast<std::size_t>(words));
  for (int v = 0; v < rows.size().height; ++v) {
    std::uint64_t* const in = rows.row(v);
    int first = 0, last = words - 1;
    while (first < words && in[first] == 0) ++first;
    if (first == words) continue;
    while (in[last] == 0) --last;
    first = std::max(first - 1, 0);
    last = std::min(last + 1, words - 1);
    in[words - 1] |= First::outside & behind;
    std::fill_n(row.data() + first, last - first + 1, 0);
    if (first > 0) row[static_cast<std::size_t>(first) - 1] = 0;
    if (last + 1 < words) row[static_cast<std::size_t>(last) + 1] = 0;
    along_row<First, reach>(in, words, first, last, row.data());
    row.back() = (row.back() & ~behind) | (Second::outside & behind);
    along_row<Second, reach>(row.data(), words, first, last, in);
    in[words - 1] &= ~behind;
  }
}

// Every word joined with those up to `reach` rows above and below.
template <class Operation, int reach>
[[gnu::always_inline]] inline void across_rows(const BitPicture& in, BitPicture& out) {
  out.resize(in.size());
  const int height = in.size().height, words = in.row_words();
  for (int v = 0; v < height; ++v) {
    if (v == reach && height > 2 * reach) {  // far from the border, the rows are one long one
      const std::uint64_t* const from = in.row(0);
      std::uint64_t* const to = out.row(0);
      const int end = (height - reach) * words;
      for (int i = reach * words; i < end; ++i) {
        std::uint64_t joined = from[i];
        for (int r = 1; r <= reach; ++r)
          joined = Operation::join(joined, Operation::join(from[i - r * words], from[i + r * words]));
        to[i] = joined;
      }
      v = height - reach;
    }
    std::uint64_t* const to = out.row(v);
    std::copy_n(in.row(v), words, to);
    for (int other = std::max(0, v - reach); other <= std::min(height - 1, v + reach); ++other) {
      const std::uint64_t* const from = in.row(other);
      for (int w = 0; w < words; ++w) to[w] = Operation::join(to[w], from[w]);
    }
  }
}

// An opening or a closing: the first operation and then the second by a square of 2 reach + 1 px. `rows` and
// `row` are room for a picture and a row.
template <class First, class Second, int reach>
[[gnu::always_inline]] inline void by_both(const BitPicture& in, BitPicture& rows,
                                           std::vector<std::uint64_t>& row, BitPicture& out) {
  across_rows<First, reach>(in, rows);
  along_rows<First, Second, reach>(rows, row);
  across_rows<Second, reach>(rows, out);
}

}  // namespace

void ClassMorphology::open(const ClassPictures& classes, ClassPictures& opened) {
  opened.resize(classes.size());
  for (std::size_t k = 0; k < classes.size(); ++k)
    compute_by<by_both<Erosion, Dilation, 1>>(instructions_, classes[k], rows_, row_, opened[k]);
}

void ClassMorphology::close(const ClassPictures& opened, ClassPictures& closed) {
  closed.resize(opened.size());
  for (std::size_t k = 0; k < opened.size(); ++k)
    compute_by<by_both<Dilation, Erosion, 2>>(instructions_, opened[k], rows_, row_, closed[k]);
  if (opened.size() < 2) return;
  // Taken: by a class of its own, or by an earlier class that closed over it.
  taken_.assign(opened[0].words().size(), 0);
  for (const BitPicture& own : opened)
    std::transform(taken_.begin(), taken_.end(), own.words().begin(), taken_.begin(), std::bit_or<>());
  for (std::size_t k = 0; k < opened.size(); ++k) {
    for (std::size_t i = 0; i < taken_.size(); ++i) {
      std::uint64_t& word = closed[k].words()[i];
      word &= ~taken_[i];
      taken_[i] |= word;
      word |= opened[k].words()[i];
    }
  }
}

}  // namespace ballservo
