#include <algorithm>

#include "perception/segmentation/regions.hpp"

namespace ballservo {
namespace {

constexpr int word_bits = BitPicture::word_bits;

// Of each pixel of a word: whether the four beside it are all set.
std::uint64_t all_beside(const BitPicture& picture, int v, int w) {
  const std::uint64_t* const row = picture.row(v);
  const std::uint64_t left = row[w] << 1 | (w > 0 ? row[w - 1] >> (word_bits - 1) : 0);
  const std::uint64_t right = row[w] >> 1 | (w + 1 < picture.row_words() ? row[w + 1] << (word_bits - 1) : 0);
  return left & right & picture.row(v - 1)[w] & picture.row(v + 1)[w];
}

constexpr int reach = 3;

// The pixels up to three to the left and right of one, from bit 0 on; beyond the border the last one goes on.
unsigned seven_around(const BitPicture& picture, int u, int v) {
  const int width = picture.size().width;
  if (u < reach || u + reach >= width) {
    unsigned bits = 0;
    for (int du = -reach; du <= reach; ++du)
      bits |= static_cast<unsigned>(picture.at(std::clamp(u + du, 0, width - 1), v)) << (du + reach);
    return bits;
  }
  const int w = (u - reach) / word_bits, shift = (u - reach) % word_bits;
  const std::uint64_t* const row = picture.row(v);
  std::uint64_t bits = row[w] >> shift;
  if (shift + 2 * reach >= word_bits) bits |= row[w + 1] << (word_bits - shift);
  return bits & 127;
}

}  // namespace

// Within a run of the region, the class's pixels are the region's: another region of the class shares no edge
// with it, and whoever is enclosed by it has been absorbed.
void RegionMap::boundary(int region, std::vector<BoundaryPixel>& boundary) const {
  boundary.clear();
  const ClassIndex color_class = regions_[static_cast<std::size_t>(region)].color_class;
  if (color_class == no_class) return;
  const BitPicture& picture = pixels_of(color_class);
  const int last_u = picture.size().width - 1, last_v = picture.size().height - 1;
  for (int i = first_run_[static_cast<std::size_t>(region)]; i >= 0;
       i = next_run_[static_cast<std::size_t>(i)]) {
    const Run& run = runs_[i];
    if (run.v == 0 || run.v == last_v) continue;
    const int begin = std::max(run.begin, 1), end = std::min(run.end, last_u);
    for (int w = begin / word_bits; w * word_bits < end; ++w) {
      const int first = w * word_bits;
      std::uint64_t found = ~all_beside(picture, run.v, w) & BitPicture::bits_from(begin - first) &
                            ~BitPicture::bits_from(end - first);
      for (; found != 0; found &= found - 1)
        boundary.push_back({first + __builtin_ctzll(found), run.v, {0, 0}});
    }
  }
}

Eigen::Vector2f outward_normal(const BitPicture& colored, const BoundaryPixel& pixel) {
  int sum_u = 0, sum_v = 0;
  for (int dv = -reach; dv <= reach; ++dv) {
    const int v = std::clamp(pixel.v_px + dv, 0, colored.size().height - 1);
    const unsigned bits = seven_around(colored, pixel.u_px, v);
    const auto has = [bits](int du) { return static_cast<int>(bits >> (reach + du) & 1); };
    for (int du = 1; du <= reach; ++du) sum_u += du * (has(du) - has(-du));
    sum_v += dv * __builtin_popcount(bits);
  }
  if (sum_u == 0 && sum_v == 0) return {0, 0};
  return -Eigen::Vector2f(static_cast<float>(sum_u), static_cast<float>(sum_v)).normalized();
}

}  // namespace ballservo
