// The taught colour table as it is looked up in: under the light as it is now, and with a quick way to tell
// the many colours that have no class.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "calibration/color/color_table.hpp"
#include "perception/segmentation/box_kernel.hpp"

namespace ballservo {

/// For each channel (blue, green, red), the cell of the taught table at which each of its 64 cells is looked
/// up: what the taught light would have shown of the same surface. Colours of the `dark` lowest cells in all
/// channels are noise, which no light changes: they stay as they were taught.
struct LightCells {
  static constexpr int dark = 3;
  std::array<std::array<std::uint8_t, ColorTable::side>, 3> taught_cell;

  /// The taught light: every cell is itself.
  static LightCells as_taught();
  bool operator==(const LightCells& other) const { return taught_cell == other.taught_cell; }
  bool operator!=(const LightCells& other) const { return !(*this == other); }
};

/// The boxes that a cell of each channel lies in, a bit for each.
using CellBits = std::array<std::array<std::uint8_t, ColorTable::side>, 3>;

/// Takes memory on construction alone; another light costs about a microsecond.
class ColorLookup {
 public:
  /// Throws InputError where the table has a class that is not in its list, or the list more than 15.
  explicit ColorLookup(std::shared_ptr<const ColorTable> colors);

  void set_light(const LightCells& light);

  const ColorTable& colors() const { return *colors_; }
  int classes() const { return static_cast<int>(colors_->classes.size()); }
  /// Under the light that was set.
  const ColorBoxes& boxes() const { return boxes_; }

  /// The class of a colour under the light that was set.
  ClassIndex classify(std::uint8_t b, std::uint8_t g, std::uint8_t r) const {
    constexpr int dark = LightCells::dark * 256 / ColorTable::side;
    if ((b | g | r) < 16 && b < dark && g < dark && r < dark) return colors_->classify(b, g, r);
    return entries_[offset_[0][b] + offset_[1][g] + offset_[2][r]];
  }

 private:
  std::shared_ptr<const ColorTable> colors_;
  const ClassIndex* entries_;
  CellBits taught_outer_{}, taught_inner_{};
  ColorBoxes boxes_;
  std::array<std::array<std::uint32_t, 256>, 3> offset_;  // each channel's part of a table entry's place
};

}  // namespace ballservo
