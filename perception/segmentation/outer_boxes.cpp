#include <algorithm>
#include <array>
#include <vector>

#include "perception/segmentation/color_boxes.hpp"

namespace ballservo {
namespace {

// The search is for boxes of blocks of 2 x 2 x 2 cells.
constexpr std::size_t block = 2, side = ColorTable::side / block;

// Which blue, green and red coordinates some blocks have: bit i of a channel's word for coordinate i.
using Extent = std::array<std::uint32_t, 3>;

Extent joined(const Extent& a, const Extent& b) { return {a[0] | b[0], a[1] | b[1], a[2] | b[2]}; }

// The tightest box around blocks of that extent, which is not empty.
ColorBox box_of(const Extent& extent) {
  ColorBox box;
  for (std::size_t c = 0; c < 3; ++c) {
    box.low[c] = static_cast<std::uint8_t>(__builtin_ctz(extent[c]));
    box.high[c] = static_cast<std::uint8_t>(31 - __builtin_clz(extent[c]));
  }
  return box;
}

// How many of a picture's pixels a box is expected to hold (on some scale), from sums over all blocks below
// and left of a corner.
class ExpectedPixels {
 public:
  explicit ExpectedPixels(const ColorTable& colors) : sums_((side + 1) * (side + 1) * (side + 1), 0.0) {
    add_greys();
    add_background(colors);
    for (std::size_t r = 0; r < side; ++r) {
      for (std::size_t g = 0; g < side; ++g) {
        double row = 0;
        for (std::size_t b = 0; b < side; ++b) {
          double& sum = at(r + 1, g + 1, b + 1);
          row += sum;
          sum = row + at(r, g + 1, b + 1) + at(r + 1, g, b + 1) - at(r, g, b + 1);
        }
      }
    }
  }

  double in(const Extent& extent) const {
    if (extent[0] == 0) return 0;
    const ColorBox box = box_of(extent);
    const auto plane = [&](std::size_t r) {
      const std::size_t g0 = box.low[1], g1 = box.high[1] + 1u, b0 = box.low[0], b1 = box.high[0] + 1u;
      return at(r, g1, b1) - at(r, g0, b1) - at(r, g1, b0) + at(r, g0, b0);
    };
    return plane(box.high[2] + 1u) - plane(box.low[2]);
  }
  double in_all() const { return at(side, side, side); }

 private:
  // Most of what pictures show is nearly grey: so much the less, the more the channels differ.
  void add_greys() {
    std::array<double, side> greyness;
    for (std::size_t difference = 0; difference < side; ++difference) {
      const double apart = static_cast<double>(difference) * block / 3.0;
      greyness[difference] = 1 / ((1 + apart * apart) * (1 + apart * apart));
    }
    for (std::size_t r = 0; r < side; ++r) {
      for (std::size_t g = 0; g < side; ++g) {
        const std::size_t low = std::min(r, g), high = std::max(r, g);
        for (std::size_t b = 0; b < side; ++b)
          greys_ += at(r + 1, g + 1, b + 1) = greyness[std::max(high, b) - std::min(low, b)];
      }
    }
  }
  // As much again as all greys, if there was one.
  void add_background(const ColorTable& colors) {
    double pixels = 0;
    for (const CellCount& cell : colors.background) pixels += cell.count;
    for (const CellCount& cell : colors.background) {
      const std::size_t b = cell.cell % 64 / block, g = cell.cell / 64 % 64 / block,
                        r = cell.cell / 4096 / block;
      at(r + 1, g + 1, b + 1) += greys_ * cell.count / pixels;
    }
  }

  double& at(std::size_t r, std::size_t g, std::size_t b) {
    return sums_[(r * (side + 1) + g) * (side + 1) + b];
  }
  double at(std::size_t r, std::size_t g, std::size_t b) const {
    return sums_[(r * (side + 1) + g) * (side + 1) + b];
  }

  std::vector<double> sums_;
  double greys_ = 0;
};

// The blocks that hold a cell with a class: bit b of word [r][g].
using Blocks = std::array<std::array<std::uint32_t, side>, side>;

Blocks blocks_with_a_class(const ColorTable& colors) {
  Blocks blocks{};
  for (std::size_t row = 0; row < ColorTable::side * ColorTable::side; ++row) {
    std::uint32_t& bits = blocks[row / ColorTable::side / block][row % ColorTable::side / block];
    const ClassIndex* const cells = &colors.table[row * ColorTable::side];
    for (std::size_t b = 0; b < side; ++b)
      bits |= static_cast<std::uint32_t>((cells[block * b] | cells[block * b + 1]) != 0) << b;
  }
  return blocks;
}

// The extent of the blocks in each slice of a box across one axis.
using Slices = std::array<Extent, side>;

// Across blue, green and red.
std::array<Slices, 3> slices_of(const Blocks& blocks, const ColorBox& box) {
  std::array<Slices, 3> slices{};
  const std::uint32_t inside = ~std::uint32_t{0} << box.low[0] & ~std::uint32_t{0} >> (31 - box.high[0]);
  for (std::size_t r = box.low[2]; r <= box.high[2]; ++r) {
    for (std::size_t g = box.low[1]; g <= box.high[1]; ++g) {
      const std::uint32_t bits = blocks[r][g] & inside;
      if (bits == 0) continue;
      const Extent extent{bits, std::uint32_t{1} << g, std::uint32_t{1} << r};
      slices[1][g] = joined(slices[1][g], extent);
      slices[2][r] = joined(slices[2][r], extent);
    }
  }
  for (std::size_t b = 0; b < side; ++b) {
    for (std::size_t i = 0; i < side; ++i) {
      slices[0][b][1] |= (slices[1][i][0] >> b & 1) << i;
      slices[0][b][2] |= (slices[2][i][0] >> b & 1) << i;
    }
    if (slices[0][b][1] != 0) slices[0][b][0] = std::uint32_t{1} << b;
  }
  return slices;
}

// Some of the blocks, and how best to make two groups of them.
struct Group {
  Group(const Blocks& blocks, const Extent& of_blocks, const ExpectedPixels& pixels) : extent(of_blocks) {
    const std::array<Slices, 3> slices = slices_of(blocks, box_of(extent));
    const double whole = pixels.in(extent), least = 1e-9 * pixels.in_all();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Slices upper = slices[axis];
      for (std::size_t i = side - 1; i > 0; --i) upper[i - 1] = joined(upper[i - 1], upper[i]);
      Extent lower{};
      for (std::size_t i = 1; i < side; ++i) {
        lower = joined(lower, slices[axis][i - 1]);
        const double less = whole - pixels.in(lower)-pixels.in(upper[i]);
        if (less > saved + least) {
          saved = less;
          parts = {lower, upper[i]};
        }
      }
    }
  }
  Extent extent;
  double saved = 0;  // by the cut; 0 where none saves anything
  std::array<Extent, 2> parts{};
};

}  // namespace

// Greedy: the box whose best cut saves most is cut, until there are enough.
std::vector<ColorBox> outer_boxes(const ColorTable& colors, int max_boxes) {
  const Blocks blocks = blocks_with_a_class(colors);
  Extent all{};
  const auto slices = slices_of(blocks, {{0, 0, 0}, {side - 1, side - 1, side - 1}});
  for (const Extent& slice : slices[2]) all = joined(all, slice);
  if (all[0] == 0) return {};
  const ExpectedPixels pixels(colors);
  std::vector<Group> groups;
  groups.emplace_back(blocks, all, pixels);
  while (static_cast<int>(groups.size()) < max_boxes) {
    const auto worst = std::max_element(groups.begin(), groups.end(),
                                        [](const Group& a, const Group& b) { return a.saved < b.saved; });
    if (worst->saved == 0) break;
    const std::array<Extent, 2> parts = worst->parts;
    *worst = Group(blocks, parts[0], pixels);
    groups.emplace_back(blocks, parts[1], pixels);
  }
  std::vector<ColorBox> boxes;
  for (const Group& group : groups) {
    ColorBox box = box_of(group.extent);
    for (std::size_t c = 0; c < 3; ++c) {
      box.low[c] = static_cast<std::uint8_t>(block * box.low[c]);
      box.high[c] = static_cast<std::uint8_t>(block * box.high[c] + block - 1);
    }
    boxes.push_back(box);
  }
  return boxes;
}

}  // namespace ballservo
