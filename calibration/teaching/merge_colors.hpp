// Colour tables of several calibrations as one.
#pragma once

#include <vector>

#include "calibration/color/color_table.hpp"

namespace ballservo {

/// Classes of one name are united, none with more than three times the weight of the smallest; others join in
/// order. The backgrounds are added and the table is made anew. Camera settings stay where all agree. Throws
/// Refusal for more than max_classes, for tables without the counts that a table can be made from, and where
/// a class would lose half of its pixels: to the background, or because classes of one name have different
/// colours.
ColorTable merge_colors(const std::vector<ColorTable>& tables);

/// What the classes of `learnt` are called when they join `base`, in order: as the class there that each
/// shares most of its colour with, if that is a third or more; otherwise by its own word, numbered where it
/// is taken.
std::vector<std::string> names_to_join(const ColorTable& learnt, const ColorTable& base);

}  // namespace ballservo
