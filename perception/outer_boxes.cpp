#include <algorithm>
#include <utility>

#include "perception/color_boxes.hpp"

namespace ballservo {
namespace {

// The search is for boxes of blocks of 2 x 2 x 2 cells.
constexpr std::size_t block = 2, side = ColorTable::side / block;
using Block = std::array<std::uint8_t, 3>;  // blue, green, red
using Blocks = std::vector<Block>;

std::size_t block_of_cell(std::size_t cell) {
  const std::size_t b = cell % 64 / block, g = cell / 64 % 64 / block, r = cell / (64 * 64) / block;
  return (r * side + g) * side + b;
}

Block block_at(std::size_t number) {
  return {static_cast<std::uint8_t>(number % side), static_cast<std::uint8_t>(number / side % side),
          static_cast<std::uint8_t>(number / (side * side))};
}

// Bounds of no block at all, to which blocks are joined.
constexpr ColorBox no_blocks{{255, 255, 255}, {0, 0, 0}};

ColorBox joined(const ColorBox& a, const ColorBox& b) {
  ColorBox box;
  for (std::size_t c = 0; c < 3; ++c) {
    box.low[c] = std::min(a.low[c], b.low[c]);
    box.high[c] = std::max(a.high[c], b.high[c]);
  }
  return box;
}

ColorBox box_of(const Block& at) { return {at, at}; }

// How many of a picture's pixels a box is expected to hold, from sums over all blocks below and left of a
// corner.
class ExpectedPixels {
 public:
  explicit ExpectedPixels(const ColorTable& colors) : sums_((side + 1) * (side + 1) * (side + 1), 0.0) {
    const std::vector<double> share = shares(colors);
    for (std::size_t r = 0; r < side; ++r) {
      for (std::size_t g = 0; g < side; ++g) {
        double row = 0;
        for (std::size_t b = 0; b < side; ++b) {
          row += share[(r * side + g) * side + b];
          at(r + 1, g + 1, b + 1) = row + at(r, g + 1, b + 1) + at(r + 1, g, b + 1) - at(r, g, b + 1);
        }
      }
    }
  }

  double in(const ColorBox& box) const {
    if (box.low[0] > box.high[0]) return 0;
    const auto plane = [&](std::size_t r) {
      const std::size_t g0 = box.low[1], g1 = box.high[1] + 1u, b0 = box.low[0], b1 = box.high[0] + 1u;
      return at(r, g1, b1) - at(r, g0, b1) - at(r, g1, b0) + at(r, g0, b0);
    };
    return plane(box.high[2] + 1u) - plane(box.low[2]);
  }

 private:
  static std::vector<double> shares(const ColorTable& colors) {
    std::vector<double> share(side * side * side);
    double all = 0;
    for (std::size_t i = 0; i < share.size(); ++i) all += share[i] = greyness(block_at(i));
    for (double& of_block : share) of_block /= all;
    double background = 0;
    for (const CellCount& cell : colors.background) background += cell.count;
    for (const CellCount& cell : colors.background)
      share[block_of_cell(cell.cell)] += cell.count / background;
    return share;
  }

  // Most of what pictures show is nearly grey: so much the less, the more the channels differ.
  static double greyness(const Block& at) {
    const auto [low, high] = std::minmax_element(at.begin(), at.end());
    const double apart = (*high - *low) * (block / 3.0);
    return 1 / ((1 + apart * apart) * (1 + apart * apart));
  }

  double& at(std::size_t r, std::size_t g, std::size_t b) {
    return sums_[(r * (side + 1) + g) * (side + 1) + b];
  }
  double at(std::size_t r, std::size_t g, std::size_t b) const {
    return sums_[(r * (side + 1) + g) * (side + 1) + b];
  }

  std::vector<double> sums_;
};

// Into two boxes: the blocks below `before` on `axis`, and the others.
struct Cut {
  std::size_t axis = 0;
  int before = 0;
  double saved = 0;
};

Cut best_cut(const Blocks& blocks, const ColorBox& whole, const ExpectedPixels& pixels) {
  Cut best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<ColorBox, side> slices;
    slices.fill(no_blocks);
    for (const Block& at : blocks) slices[at[axis]] = joined(slices[at[axis]], box_of(at));
    std::array<ColorBox, side> upper = slices;
    for (std::size_t i = side - 1; i > 0; --i) upper[i - 1] = joined(upper[i - 1], upper[i]);
    ColorBox lower = no_blocks;
    for (std::size_t i = 1; i < side; ++i) {
      lower = joined(lower, slices[i - 1]);
      const double saved = pixels.in(whole)-pixels.in(lower)-pixels.in(upper[i]);
      if (saved > best.saved + 1e-9) best = {axis, static_cast<int>(i), saved};
    }
  }
  return best;
}

struct Group {
  Group(Blocks of_blocks, const ExpectedPixels& pixels) : blocks(std::move(of_blocks)), box(no_blocks) {
    for (const Block& at : blocks) box = joined(box, box_of(at));
    cut = best_cut(blocks, box, pixels);
  }
  Blocks blocks;
  ColorBox box;
  Cut cut;
};

Blocks blocks_with_a_class(const ColorTable& colors) {
  std::vector<bool> has_class(side * side * side, false);
  for (std::size_t i = 0; i < colors.table.size(); ++i) {
    if (colors.table[i] != no_class) has_class[block_of_cell(i)] = true;
  }
  Blocks blocks;
  for (std::size_t i = 0; i < has_class.size(); ++i) {
    if (has_class[i]) blocks.push_back(block_at(i));
  }
  return blocks;
}

}  // namespace

// Greedy: the box whose best cut saves most is cut, until there are enough.
std::vector<ColorBox> outer_boxes(const ColorTable& colors, int max_boxes) {
  Blocks all = blocks_with_a_class(colors);
  if (all.empty()) return {};
  const ExpectedPixels pixels(colors);
  std::vector<Group> groups;
  groups.emplace_back(std::move(all), pixels);
  while (static_cast<int>(groups.size()) < max_boxes) {
    const auto worst = std::max_element(groups.begin(), groups.end(), [](const Group& a, const Group& b) {
      return a.cut.saved < b.cut.saved;
    });
    const Cut cut = worst->cut;
    if (cut.before == 0) break;
    Blocks blocks = std::move(worst->blocks);
    const auto middle = std::partition(blocks.begin(), blocks.end(),
                                       [&](const Block& at) { return at[cut.axis] < cut.before; });
    *worst = Group({blocks.begin(), middle}, pixels);
    groups.emplace_back(Blocks(middle, blocks.end()), pixels);
  }
  std::vector<ColorBox> boxes;
  for (const Group& group : groups) {
    ColorBox box;
    for (std::size_t c = 0; c < 3; ++c) {
      box.low[c] = static_cast<std::uint8_t>(block * group.box.low[c]);
      box.high[c] = static_cast<std::uint8_t>(block * group.box.high[c] + block - 1);
    }
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace ballservo
