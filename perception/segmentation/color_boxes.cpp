#include "perception/segmentation/color_boxes.hpp"

#include <algorithm>

namespace ballservo {
namespace {

// A box of blocks of so many cells a side.
ColorBox in_cells(ColorBox box, std::size_t block) {
  for (std::size_t c = 0; c < 3; ++c) {
    box.low[c] = static_cast<std::uint8_t>(block * box.low[c]);
    box.high[c] = static_cast<std::uint8_t>(block * box.high[c] + block - 1);
  }
  return box;
}

// ---- inner boxes: of blocks of 4 x 4 x 4 cells

constexpr std::size_t inner_block = 4, inner_side = ColorTable::side / inner_block;
template <class T, std::size_t n>
using Blocks = std::array<std::array<std::array<T, inner_side>, n>, n>;  // red, green, blue

// The class of all of a block's cells, if they have one.
ClassIndex class_of_block(const ColorTable& colors, std::size_t r, std::size_t g, std::size_t b) {
  const ClassIndex* const corner =
      &colors.table[(inner_block * r << 12) | (inner_block * g << 6) | (inner_block * b)];
  for (std::size_t i = 0; i < inner_block; ++i) {
    for (std::size_t j = 0; j < inner_block; ++j) {
      const ClassIndex* const cells = corner + (i << 12 | j << 6);
      if (!std::all_of(cells, cells + inner_block, [&](ClassIndex cell) { return cell == *corner; }))
        return no_class;
    }
  }
  return *corner;
}

// The box of a class's blocks that holds most which are in none yet.
class InnerSearch {
 public:
  struct Found {
    int gain = 0;
    ColorBox box;  // of blocks
  };

  explicit InnerSearch(const ColorTable& colors) {
    for (std::size_t r = 0; r < inner_side; ++r) {
      for (std::size_t g = 0; g < inner_side; ++g) {
        for (std::size_t b = 0; b < inner_side; ++b) classes_[r][g][b] = class_of_block(colors, r, g, b);
        free_[r][g].fill(1);
      }
    }
  }

  Found best_box(ClassIndex wanted) const {
    const Blocks<int, inner_side + 1> before = gains_before(wanted);
    Found best{0, {{}, {}, wanted}};
    for (std::size_t r0 = 0; r0 < inner_side; ++r0) {
      bool whole_red = true;  // some column of blocks from r0 on is of the class
      for (std::size_t r1 = r0; r1 < inner_side && whole_red; ++r1) {
        whole_red = false;
        for (std::size_t g0 = 0; g0 < inner_side; ++g0) {
          bool whole = true;
          for (std::size_t g1 = g0; g1 < inner_side && whole; ++g1) {
            whole = false;
            int gain = 0;
            for (std::size_t b = 0, b0 = 0; b < inner_side; ++b) {
              const int column = before[r1 + 1][g1 + 1][b] - before[r0][g1 + 1][b] -
                                 (before[r1 + 1][g0][b] - before[r0][g0][b]);
              if (column < 0) {
                gain = 0;
                b0 = b + 1;
                continue;
              }
              whole = whole_red = true;
              gain += column;
              if (gain > best.gain) best = {gain, {indices(b0, g0, r0), indices(b, g1, r1), wanted}};
            }
          }
        }
      }
    }
    return best;
  }

  void take(const ColorBox& box) {
    for (std::size_t r = box.low[2]; r <= box.high[2]; ++r) {
      for (std::size_t g = box.low[1]; g <= box.high[1]; ++g)
        std::fill(&free_[r][g][box.low[0]], &free_[r][g][box.high[0]] + 1, 0);
    }
  }

 private:
  static std::array<std::uint8_t, 3> indices(std::size_t b, std::size_t g, std::size_t r) {
    return {static_cast<std::uint8_t>(b), static_cast<std::uint8_t>(g), static_cast<std::uint8_t>(r)};
  }
  // For each blue, of all blocks before a red and a green: how many are in no box, less all that there are
  // for each of no or another class.
  Blocks<int, inner_side + 1> gains_before(ClassIndex wanted) const {
    constexpr int all = inner_side * inner_side * inner_side;
    Blocks<int, inner_side + 1> before{};
    for (std::size_t r = 0; r < inner_side; ++r) {
      for (std::size_t g = 0; g < inner_side; ++g) {
        for (std::size_t b = 0; b < inner_side; ++b)
          before[r + 1][g + 1][b] = before[r][g + 1][b] + before[r + 1][g][b] - before[r][g][b] +
                                    (classes_[r][g][b] == wanted ? free_[r][g][b] : -all);
      }
    }
    return before;
  }

  Blocks<ClassIndex, inner_side> classes_;
  Blocks<int, inner_side> free_;  // 1, and 0 for a block that is in a box
};

// ---- outer boxes: of blocks of 2 x 2 x 2 cells

constexpr std::size_t outer_block = 2, outer_side = ColorTable::side / outer_block;

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

// How many pixels a box is expected to hold (on some scale), from sums over all blocks below a corner.
class ExpectedPixels {
 public:
  explicit ExpectedPixels(const ColorTable& colors) : sums_(outer_side + 1) {
    add_greys();
    add_background(colors);
    for (std::size_t r = 0; r < outer_side; ++r) {
      for (std::size_t g = 0; g < outer_side; ++g) {
        double row = 0;
        for (std::size_t b = 0; b < outer_side; ++b) {
          double& sum = sums_[r + 1][g + 1][b + 1];
          row += sum;
          sum = row + sums_[r][g + 1][b + 1] + sums_[r + 1][g][b + 1] - sums_[r][g][b + 1];
        }
      }
    }
  }

  double in(const Extent& extent) const {
    if (extent[0] == 0) return 0;
    const ColorBox box = box_of(extent);
    const auto plane = [&](std::size_t r) {
      const std::size_t g0 = box.low[1], g1 = box.high[1] + 1u, b0 = box.low[0], b1 = box.high[0] + 1u;
      return sums_[r][g1][b1] - sums_[r][g0][b1] - sums_[r][g1][b0] + sums_[r][g0][b0];
    };
    return plane(box.high[2] + 1u) - plane(box.low[2]);
  }
  double in_all() const { return sums_[outer_side][outer_side][outer_side]; }

 private:
  // Most of what pictures show is nearly grey: so much the less, the more the channels differ.
  void add_greys() {
    std::array<double, outer_side> greyness;
    for (std::size_t difference = 0; difference < outer_side; ++difference) {
      const double apart = static_cast<double>(difference) * outer_block / 3.0;
      greyness[difference] = 1 / ((1 + apart * apart) * (1 + apart * apart));
    }
    for (std::size_t r = 0; r < outer_side; ++r) {
      for (std::size_t g = 0; g < outer_side; ++g) {
        const std::size_t low = std::min(r, g), high = std::max(r, g);
        for (std::size_t b = 0; b < outer_side; ++b)
          greys_ += sums_[r + 1][g + 1][b + 1] = greyness[std::max(high, b) - std::min(low, b)];
      }
    }
  }
  // As much again as all greys, if there was one.
  void add_background(const ColorTable& colors) {
    double pixels = 0;
    for (const CellCount& cell : colors.background) pixels += cell.count;
    for (const CellCount& cell : colors.background) {
      const std::size_t b = cell.cell % 64 / outer_block, g = cell.cell / 64 % 64 / outer_block,
                        r = cell.cell / 4096 / outer_block;
      sums_[r + 1][g + 1][b + 1] += greys_ * cell.count / pixels;
    }
  }

  std::vector<std::array<std::array<double, outer_side + 1>, outer_side + 1>> sums_;  // red, green, blue
  double greys_ = 0;
};

// The blocks that hold a cell with a class: bit b of word [r][g].
using BlockBits = std::array<std::array<std::uint32_t, outer_side>, outer_side>;

BlockBits blocks_with_a_class(const ColorTable& colors) {
  BlockBits blocks{};
  for (std::size_t row = 0; row < ColorTable::side * ColorTable::side; ++row) {
    std::uint32_t& bits = blocks[row / ColorTable::side / outer_block][row % ColorTable::side / outer_block];
    const ClassIndex* const cells = &colors.table[row * ColorTable::side];
    for (std::size_t b = 0; b < outer_side; ++b)
      bits |= static_cast<std::uint32_t>((cells[outer_block * b] | cells[outer_block * b + 1]) != 0) << b;
  }
  return blocks;
}

// The extent of the blocks in each slice of a box across one axis.
using Slices = std::array<Extent, outer_side>;

// Across blue, green and red.
std::array<Slices, 3> slices_of(const BlockBits& blocks, const ColorBox& box) {
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
  for (std::size_t b = 0; b < outer_side; ++b) {
    for (std::size_t i = 0; i < outer_side; ++i) {
      slices[0][b][1] |= (slices[1][i][0] >> b & 1) << i;
      slices[0][b][2] |= (slices[2][i][0] >> b & 1) << i;
    }
    if (slices[0][b][1] != 0) slices[0][b][0] = std::uint32_t{1} << b;
  }
  return slices;
}

// Some of the blocks, and how best to make two groups of them.
struct Group {
  Group(const BlockBits& blocks, const Extent& of_blocks, const ExpectedPixels& pixels) : extent(of_blocks) {
    const std::array<Slices, 3> slices = slices_of(blocks, box_of(extent));
    const double whole = pixels.in(extent), least = 1e-9 * pixels.in_all();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Slices upper = slices[axis];
      for (std::size_t i = outer_side - 1; i > 0; --i) upper[i - 1] = joined(upper[i - 1], upper[i]);
      Extent lower{};
      for (std::size_t i = 1; i < outer_side; ++i) {
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

// Greedy: the box that holds most blocks which are in none yet.
std::vector<ColorBox> inner_boxes(const ColorTable& colors, int max_boxes) {
  InnerSearch search(colors);
  std::vector<InnerSearch::Found> best_of_class;
  for (std::size_t k = 1; k <= colors.classes.size(); ++k)
    best_of_class.push_back(search.best_box(static_cast<ClassIndex>(k)));
  std::vector<ColorBox> boxes;
  while (static_cast<int>(boxes.size()) < max_boxes && !best_of_class.empty()) {
    const auto best = std::max_element(best_of_class.begin(), best_of_class.end(),
                                       [](const auto& a, const auto& b) { return a.gain < b.gain; });
    if (best->gain == 0) break;
    boxes.push_back(in_cells(best->box, inner_block));
    search.take(best->box);
    *best = search.best_box(best->box.color_class);
  }
  return boxes;
}

// Greedy: the box whose best cut saves most is cut, until there are enough.
std::vector<ColorBox> outer_boxes(const ColorTable& colors, int max_boxes) {
  const BlockBits blocks = blocks_with_a_class(colors);
  Extent all{};
  const auto slices = slices_of(blocks, {{0, 0, 0}, {outer_side - 1, outer_side - 1, outer_side - 1}});
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
  for (const Group& group : groups) boxes.push_back(in_cells(box_of(group.extent), outer_block));
  return boxes;
}

}  // namespace ballservo
