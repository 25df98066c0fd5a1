#include "perception/segmentation/boundary_chain.hpp"

#include <array>
#include <cstdint>

namespace ballservo {
namespace {

constexpr int word_bits = BitPicture::word_bits;

struct Move {
  std::int8_t du = 0, dv = 0;
};

// A pixel that shares an edge comes before one that shares a corner: else it would be left behind.
constexpr std::array<Move, 8> moves{Move{1, 0}, Move{0, 1},  Move{-1, 0},  Move{0, -1},
                                    Move{1, 1}, Move{-1, 1}, Move{-1, -1}, Move{1, -1}};

// Where to go from the middle of 3x3 pixels, by which of them wait: bit 3 (dv + 1) + du + 1. (0, 0) where
// none does.
constexpr std::array<Move, 512> make_next_moves() {
  std::array<Move, 512> table{};
  for (unsigned around = 0; around < 512; ++around) {
    for (std::size_t i = moves.size(); i-- > 0;) {
      if (around >> (3 * (moves[i].dv + 1) + moves[i].du + 1) & 1) table[around] = moves[i];
    }
  }
  return table;
}
constexpr std::array<Move, 512> next_moves = make_next_moves();

// The pixels u - 1 to u + 1 of a row.
unsigned three(const std::uint64_t* row, int u) {
  const int w = (u - 1) / word_bits, shift = (u - 1) % word_bits;
  std::uint64_t bits = row[w] >> shift;
  if (shift > word_bits - 3) bits |= row[w + 1] << (word_bits - shift);
  return static_cast<unsigned>(bits & 7);
}

}  // namespace

void BoundaryChain::order(std::vector<BoundaryPixel>& boundary, cv::Size size) {
  waiting_.resize(size);
  for (const BoundaryPixel& p : boundary) waiting_.fill(p.v_px, p.u_px, p.u_px + 1, true);
  ordered_.clear();
  ordered_.reserve(boundary.capacity());  // they are swapped: neither shall grow again
  for (const BoundaryPixel& first : boundary) {
    if (!waiting_.at(first.u_px, first.v_px)) continue;
    int u = first.u_px, v = first.v_px;
    while (true) {
      waiting_.row(v)[u / word_bits] &= ~(std::uint64_t{1} << (u % word_bits));
      ordered_.push_back({u, v, {0, 0}});
      const unsigned around =
          three(waiting_.row(v - 1), u) | three(waiting_.row(v), u) << 3 | three(waiting_.row(v + 1), u) << 6;
      const Move move = next_moves[around];
      if (move.du == 0 && move.dv == 0) break;
      u += move.du;
      v += move.dv;
    }
  }
  boundary.swap(ordered_);
}

}  // namespace ballservo
