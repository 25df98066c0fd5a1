// Which class a colour belongs to: a table over RGB with 6 bits a channel (paper, "Calibrage", 2e).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ballservo {

/// A class number: 0 is "no class", classes count from 1 in the order of `ColorTable::classes`.
using ClassIndex = std::uint8_t;
inline constexpr ClassIndex no_class = 0;
inline constexpr int max_classes = 15;

/// Counts of samples over (a, b) of CIE Lab: 128 x 128 cells of 2 units, a and b from -128 to 128, row by row
/// of b.
struct ChromaHistogram {
  static constexpr int side = 128;
  static constexpr double cell = 2.0;
  std::vector<std::uint32_t> counts = std::vector<std::uint32_t>(side * side, 0);
};

/// How many pixels fell into one cell of a ColorTable.
struct CellCount {
  std::uint32_t cell = 0;
  std::uint32_t count = 0;
};

/// The occupied cells in rising order, each once.
using OccupiedCells = std::vector<CellCount>;

/// What is known of one class of ball colours.
struct ColorClass {
  std::string name;           ///< 1 to 64 of a-z, 0-9 and _, beginning with a letter
  std::uint64_t samples = 0;  ///< pixels that it was learnt from
  ChromaHistogram histogram;  ///< where they lie in (a, b) ...
  OccupiedCells cells;        ///< ... and in RGB: what a table can be made from anew
};

/// The table that the on-line classification reads. Entry order: blue fastest, then green, then red.
struct ColorTable {
  static constexpr int side = 64;
  static constexpr int entries = side * side * side;

  std::vector<ClassIndex> table = std::vector<ClassIndex>(entries, no_class);
  std::vector<ColorClass> classes;  ///< class k of the table is classes[k - 1]
  OccupiedCells background;         ///< the pixels off every ball in the pictures that it was learnt from
  /// How the camera was set, by V4L2's names, where it was known ("exposure": 156).
  std::map<std::string, double> camera_settings;

  static constexpr int index(std::uint8_t b, std::uint8_t g, std::uint8_t r) {
    return ((r >> 2) << 12) | ((g >> 2) << 6) | (b >> 2);
  }
  ClassIndex classify(std::uint8_t b, std::uint8_t g, std::uint8_t r) const { return table[index(b, g, r)]; }
  /// The number of the class of that name; nothing if there is none.
  std::optional<ClassIndex> find(const std::string& name) const {
    for (std::size_t k = 0; k < classes.size(); ++k)
      if (classes[k].name == name) return static_cast<ClassIndex>(k + 1);
    return {};
  }
  std::vector<std::string> class_names() const {
    std::vector<std::string> names;
    for (const ColorClass& color : classes) names.push_back(color.name);
    return names;
  }
  /// The name of a class of this table; not for `no_class`.
  const std::string& name_of(ClassIndex color_class) const {
    return classes[static_cast<std::size_t>(color_class) - 1].name;
  }
};

}  // namespace ballservo
