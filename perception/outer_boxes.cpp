#include <algorithm>
#include <utility>

#include "perception/color_boxes.hpp"

namespace ballservo {
namespace {

constexpr std::size_t side = ColorTable::side;
using Cell = std::array<std::uint8_t, 3>;
using Cells = std::vector<Cell>;

// Bounds of no cell at all, to which cells are joined.
constexpr ColorBox no_cells{{255, 255, 255}, {0, 0, 0}};

ColorBox joined(const ColorBox& a, const ColorBox& b) {
  ColorBox box;
  for (std::size_t c = 0; c < 3; ++c) {
    box.low[c] = std::min(a.low[c], b.low[c]);
    box.high[c] = std::max(a.high[c], b.high[c]);
  }
  return box;
}

ColorBox box_of(const Cell& cell) { return {cell, cell}; }

// How many of a picture's pixels a box is expected to hold, as sums over all cells below and left of a
// corner.
class ExpectedPixels {
 public:
  explicit ExpectedPixels(const ColorTable& colors) : sums_((side + 1) * (side + 1) * (side + 1), 0.0) {
    std::vector<double> share(ColorTable::entries);
    double all = 0;
    for (std::size_t i = 0; i < share.size(); ++i) all += share[i] = greyness(i);
    for (double& cell : share) cell /= all;
    double background = 0;
    for (const CellCount& cell : colors.background) background += cell.count;
    for (const CellCount& cell : colors.background) share[cell.cell] += cell.count / background;
    for (std::size_t r = 0; r < side; ++r) {
      for (std::size_t g = 0; g < side; ++g) {
        double row = 0;
        for (std::size_t b = 0; b < side; ++b) {
          row += share[(r << 12) | (g << 6) | b];
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
  // Most of what pictures show is nearly grey: so much the less, the more the channels differ.
  static double greyness(std::size_t cell) {
    const int b = cell & 63, g = (cell >> 6) & 63, r = static_cast<int>(cell >> 12);
    const double apart = (std::max({b, g, r}) - std::min({b, g, r})) / 3.0;
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

// Into two boxes: the cells below `before` on `axis`, and the others.
struct Cut {
  std::size_t axis = 0;
  int before = 0;
  double saved = 0;
};

Cut best_cut(const Cells& cells, const ColorBox& whole, const ExpectedPixels& pixels) {
  Cut best;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<ColorBox, side> slices;
    slices.fill(no_cells);
    for (const Cell& cell : cells) slices[cell[axis]] = joined(slices[cell[axis]], box_of(cell));
    std::array<ColorBox, side> upper = slices;
    for (std::size_t i = side - 1; i > 0; --i) upper[i - 1] = joined(upper[i - 1], upper[i]);
    ColorBox lower = no_cells;
    for (std::size_t i = 1; i < side; ++i) {
      lower = joined(lower, slices[i - 1]);
      const double saved = pixels.in(whole)-pixels.in(lower)-pixels.in(upper[i]);
      if (saved > best.saved + 1e-9) best = {axis, static_cast<int>(i), saved};
    }
  }
  return best;
}

struct Group {
  Group(Cells of_cells, const ExpectedPixels& pixels) : cells(std::move(of_cells)), box(no_cells) {
    for (const Cell& cell : cells) box = joined(box, box_of(cell));
    cut = best_cut(cells, box, pixels);
  }
  Cells cells;
  ColorBox box;
  Cut cut;
};

Cells cells_with_a_class(const ColorTable& colors) {
  Cells cells;
  for (std::size_t i = 0; i < colors.table.size(); ++i) {
    if (colors.table[i] == no_class) continue;
    cells.push_back({static_cast<std::uint8_t>(i & 63), static_cast<std::uint8_t>((i >> 6) & 63),
                     static_cast<std::uint8_t>(i >> 12)});
  }
  return cells;
}

}  // namespace

// Greedy: the box whose best cut saves most is cut, until there are enough.
std::vector<ColorBox> outer_boxes(const ColorTable& colors, int max_boxes) {
  Cells all = cells_with_a_class(colors);
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
    Cells cells = std::move(worst->cells);
    const auto middle = std::partition(cells.begin(), cells.end(),
                                       [&](const Cell& cell) { return cell[cut.axis] < cut.before; });
    *worst = Group({cells.begin(), middle}, pixels);
    groups.emplace_back(Cells(middle, cells.end()), pixels);
  }
  std::vector<ColorBox> boxes;
  for (const Group& group : groups) boxes.push_back(group.box);
  return boxes;
}

}  // namespace ballservo
