// The 64 x 64 x 64 table from the groups of several classes (paper, "Calibrage", 2e).
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "calibration/teaching/chroma_group.hpp"
#include "calibration/teaching/color_samples.hpp"

namespace ballservo {

/// What the table is made of: one class's samples and the group that they gave.
struct ClassEvidence {
  OccupiedCells cells;
  ChromaGroup group;
};

/// A class's smoothed density over coarse cells of (L, a, b), 8 x 4 x 4 units: sums to 1 (to nothing for no
/// cells).
std::vector<float> lab_density(const OccupiedCells& cells);

/// The common area of two such densities: 1 for the same colour, 0 for colours that share no cell.
double common_area(const std::vector<float>& a, const std::vector<float>& b);

/// The class of every RGB cell, by the colour at its centre:
/// - without a class where the colour is too dark or too grey (see has_color), or where it lies in no
/// group;
/// - of the class with the highest density where groups overlap: over the RGB cells around it where any of
/// them was
///   seen there (red in the light and orange in the shade share their chroma), over (a, b) elsewhere;
/// - without a class again where the background of the pictures is denser there than a quarter of the ball
/// (both as
///   densities over L, a and b, so that a bright wall does not take a ball's shade of the same chroma with
///   it). The class's core is given up only where the background is three times as dense: what little the
///   background has of it are things of the ball's own colour, which no table can tell apart.
/// `background` counts the pictures' pixels off every ball; empty for none.
std::vector<ClassIndex> class_table(const std::vector<ClassEvidence>& classes,
                                    const OccupiedCells& background);

/// How many of the counted pixels a table gives to no class, to class 1, and so on.
std::vector<double> pixels_of_classes(const OccupiedCells& cells, const ColorTable& colors);

/// Makes the table anew from what is stored of its classes and its background.
void rebuild(ColorTable& colors);

/// The table for a picture (8-bit BGR) whose ground has the balls' colours, too: made anew with the picture
/// as its background, in which a ball itself hardly counts. Nothing where that colours little of the picture,
/// or the classes come without their cells.
std::optional<ColorTable> before_own_ground(const ColorTable& colors, const cv::Mat& bgr);

}  // namespace ballservo
