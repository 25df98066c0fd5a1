// From the chroma histogram of a class to the group of cells that is its colour (paper, "Calibrage", 2d).
#pragma once

#include <opencv2/core.hpp>

#include "calibration/color/color_table.hpp"
#include "calibration/teaching/color_samples.hpp"

namespace ballservo {

/// The colour of a class over (a, b), 128 x 128 as ChromaHistogram, row by row of b.
struct ChromaGroup {
  cv::Mat1b cells;    ///< 255 in the one connected group
  cv::Mat1b core;     ///< 255 where the fullest cells hold 70 % of the samples: beyond doubt this class
  cv::Mat1f density;  ///< probability a cell, smoothed; 0 outside the group
};

ChromaHistogram chroma_histogram(const ColorSamples& samples);

/// Smooths the histogram, drops the emptiest cells (2 % of the samples), closes holes and gaps, keeps the
/// fullest connected group, and lets it reach a little further: towards and away from grey, where the same
/// ball lies in weaker and stronger light, and 4 degrees of hue to either side, where it lies under another
/// white balance. Empty masks for no samples.
ChromaGroup chroma_group(const ChromaHistogram& histogram);

}  // namespace ballservo
