// The 64 x 64 x 64 table from the groups of several classes (paper, "Calibrage", 2e).
#pragma once

#include <vector>

#include "calibration/color/chroma_group.hpp"
#include "calibration/color/color_samples.hpp"
#include "calibration/color/color_table.hpp"

namespace ballservo {

/// What the table is made of: one class's samples and the group that they gave.
struct ClassEvidence {
  ColorSamples samples;
  ChromaGroup group;
};

/// The class of every RGB cell, by the colour at its centre:
/// - without a class where the colour is too dark or too grey (see SampleOptions), or where it lies in no
/// group;
/// - of the class with the highest density where groups overlap: over the RGB cells around it where any of
/// them was
///   seen there (red in the light and orange in the shade share their chroma), over (a, b) elsewhere;
/// - without a class again where the background of the pictures is denser there than a quarter of the ball
/// (both as
///   densities over L, a and b, so that a bright wall does not take a ball's shade of the same chroma with
///   it). The class's core is given up only where the background is three times as dense: what little the
///   background has of it are things of the ball's own colour, which no table can tell apart.
/// `background` counts the pictures' pixels off every ball, by cells of ColorTable; empty for none.
std::vector<ClassIndex> class_table(const std::vector<ClassEvidence>& classes, const CellCounts& background,
                                    const SampleOptions& options);

}  // namespace ballservo
