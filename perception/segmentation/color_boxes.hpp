// Where the classes lie in the colour table, in boxes: what most pixels are told from without looking them
// up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "calibration/color/color_table.hpp"

namespace ballservo {

/// A block of the table's cells, bounds included; channels in the order blue, green, red.
struct ColorBox {
  std::array<std::uint8_t, 3> low{}, high{};
  ClassIndex color_class = no_class;  ///< of all its cells, where it is an inner box
};

/// At most `max_boxes` boxes that together hold every cell with a class, and little of what pictures show
/// otherwise: the background that the table was learnt from, and greyish colours. On every second cell.
std::vector<ColorBox> outer_boxes(const ColorTable& colors, int max_boxes);

/// At most `max_boxes` boxes of cells of one class each, the largest first. On every fourth cell.
std::vector<ColorBox> inner_boxes(const ColorTable& colors, int max_boxes);

}  // namespace ballservo
