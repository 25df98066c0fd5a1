#include <algorithm>

#include "perception/segmentation/color_boxes.hpp"

namespace ballservo {
namespace {

// The search is for boxes of blocks of 4 x 4 x 4 cells.
constexpr std::size_t block = 4, side = ColorTable::side / block;
template <class T>
using Blocks = std::array<std::array<std::array<T, side>, side>, side>;  // red, green, blue

struct Search {
  Blocks<ClassIndex> classes;  // of all the block's cells
  Blocks<int> gain;            // of a block in a box: 1, and 0 once it is in one
};

ClassIndex class_of_block(const ColorTable& colors, std::size_t r, std::size_t g, std::size_t b) {
  const ClassIndex* const corner = &colors.table[(block * r << 12) | (block * g << 6) | (block * b)];
  for (std::size_t i = 0; i < block; ++i) {
    for (std::size_t j = 0; j < block; ++j) {
      const ClassIndex* const cells = corner + (i << 12 | j << 6);
      if (!std::all_of(cells, cells + block, [&](ClassIndex cell) { return cell == *corner; }))
        return no_class;
    }
  }
  return *corner;
}

Search start(const ColorTable& colors) {
  Search search;
  for (std::size_t r = 0; r < side; ++r) {
    for (std::size_t g = 0; g < side; ++g) {
      for (std::size_t b = 0; b < side; ++b) {
        search.classes[r][g][b] = class_of_block(colors, r, g, b);
        search.gain[r][g][b] = 1;
      }
    }
  }
  return search;
}

struct Found {
  int gain = 0;
  std::array<std::size_t, 3> low{}, high{};  // blocks, in the order blue, green, red
};

// A face of the boxes from red r0 to r1: whether all blocks behind a place are of the class, and their gain.
struct Column {
  bool whole = true;
  int gain = 0;
};
using Face = std::array<std::array<Column, side>, side>;

bool extend(Column& column, ClassIndex found, ClassIndex wanted, int gain) {
  column.whole = column.whole && found == wanted;
  column.gain += gain;
  return column.whole;
}

// The best rectangle in the face.
void search_face(const Face& face, std::size_t r0, std::size_t r1, Found& best) {
  for (std::size_t g0 = 0; g0 < side; ++g0) {
    std::array<Column, side> columns{};
    for (std::size_t g1 = g0; g1 < side; ++g1) {
      bool any = false;
      int gain = 0;
      std::size_t b0 = 0;
      for (std::size_t b = 0; b < side; ++b) {
        Column& column = columns[b];
        column.whole = column.whole && face[g1][b].whole;
        column.gain += face[g1][b].gain;
        if (!column.whole) {
          gain = 0;
          b0 = b + 1;
          continue;
        }
        any = true;
        gain += column.gain;
        if (gain > best.gain) best = {gain, {b0, g0, r0}, {b, g1, r1}};
      }
      if (!any) break;
    }
  }
}

Found best_box(const Search& search, ClassIndex wanted) {
  Found best;
  for (std::size_t r0 = 0; r0 < side; ++r0) {
    Face face{};
    for (std::size_t r1 = r0; r1 < side; ++r1) {
      bool any = false;
      int gain = 0;
      for (std::size_t g = 0; g < side; ++g) {
        for (std::size_t b = 0; b < side; ++b) {
          if (!extend(face[g][b], search.classes[r1][g][b], wanted, search.gain[r1][g][b])) continue;
          any = true;
          gain += face[g][b].gain;
        }
      }
      if (!any) break;
      if (gain > best.gain) search_face(face, r0, r1, best);
    }
  }
  return best;
}

void take(Search& search, const Found& box) {
  for (std::size_t r = box.low[2]; r <= box.high[2]; ++r) {
    for (std::size_t g = box.low[1]; g <= box.high[1]; ++g) {
      for (std::size_t b = box.low[0]; b <= box.high[0]; ++b) search.gain[r][g][b] = 0;
    }
  }
}

}  // namespace

// Greedy: the box that holds most blocks which are in none yet.
std::vector<ColorBox> inner_boxes(const ColorTable& colors, int max_boxes) {
  Search search = start(colors);
  const std::size_t classes = colors.classes.size();
  std::vector<Found> best_of_class(classes);
  for (std::size_t k = 0; k < classes; ++k)
    best_of_class[k] = best_box(search, static_cast<ClassIndex>(k + 1));
  std::vector<ColorBox> boxes;
  while (static_cast<int>(boxes.size()) < max_boxes && !best_of_class.empty()) {
    const auto best = std::max_element(best_of_class.begin(), best_of_class.end(),
                                       [](const Found& a, const Found& b) { return a.gain < b.gain; });
    if (best->gain == 0) break;
    ColorBox box;
    for (std::size_t c = 0; c < 3; ++c) {
      box.low[c] = static_cast<std::uint8_t>(block * best->low[c]);
      box.high[c] = static_cast<std::uint8_t>(block * best->high[c] + block - 1);
    }
    box.color_class = static_cast<ClassIndex>(best - best_of_class.begin() + 1);
    boxes.push_back(box);
    take(search, *best);
    *best = best_box(search, box.color_class);
  }
  return boxes;
}

}  // namespace ballservo
