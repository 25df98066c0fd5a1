// The round coloured regions of a picture: what colour calibration takes for balls (paper, "Calibrage",
// 2a-b).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calibration/teaching/mean_shift.hpp"

namespace ballservo {

/// What counts as a round coloured region.
struct RoundRegionOptions {
  MeanShiftOptions mean_shift;
  double min_radius_px = 4.5;          ///< at the working scale; 1 or more
  double sure_radius_px = 8;           ///< below it a few pixels of anything are round, and ...
  double min_fit_ratio = 0.4;          ///< boundary inliers x fill, 0 to 1, of what is larger
  double small_fit_ratio = 0.75;       ///< ... the ratio that is asked for rises to this at min_radius_px
  double min_smeared_fit_ratio = 0.3;  ///< the same for a ball smeared by motion, 0 to 1
  double min_chroma = 6;               ///< least distance of the modes' (u*, v*) from the picture's own grey
  /// Least distance of a ball's mean (u*, v*) from that of what is around it: below it the region is a patch
  /// of its surroundings, which says what else is in the picture but is no ball.
  double min_contrast = 5;
  double min_hue_agreement = 0.85;  ///< of its colours: their (u*, v*) summed, over their lengths summed
  std::uint64_t seed = 0;           ///< of the circle votes
  std::function<void()> before_each_test{};  ///< of a region's roundness; what it throws ends the search

  /// Throws InputError with every value out of range.
  void validate() const;
};

/// A region that passed the circle test.
struct RoundRegion {
  Eigen::Vector2d center_px{0, 0};  ///< in the picture as given
  double radius_px = 0;
  double inlier_fraction = 0;  ///< of the boundary, on the circle
  double fill =
      0;  ///< area common to region and disc / area that either covers; the region without its holes
  double fit_ratio = 0;  ///< inlier_fraction x fill: near 1 for a whole ball
  bool smeared =
      false;            ///< an ellipse, as motion makes of a ball: `inlier_fraction` is 0.8 x the axes' ratio
  double contrast = 0;  ///< distance of its mean (u*, v*) from that of a ring around it
  bool stands_out = false;  ///< by that
  cv::Mat mask;  ///< CV_8U, 255 inside the region, holes filled; empty for a disc that the user pointed at
  cv::Point mask_origin;  ///< where the mask's top left pixel lies in the working picture
};

/// What the search saw, and what it found.
struct RoundRegions {
  cv::Mat modes;                     ///< (u*, v*) after mean shift, CV_32FC2, at the working scale
  double scale = 1;                  ///< working pixels per pixel of the picture, at most 1
  std::vector<RoundRegion> regions;  ///< disjoint, the best fit first
};

/// Mean shift, components and the circle test. The components are made at several strictnesses (how far
/// neighbours' modes may differ, how much chroma counts as colour), because no single one suits both a pale
/// ball in dim light and a glossy one beside its own reflection; a place keeps its roundest region, of those
/// that stand out where any does. `bgr` is CV_8UC3. Throws InputError for options out of range or a picture
/// of another type.
RoundRegions find_round_regions(const cv::Mat& bgr, const RoundRegionOptions& options = {});

}  // namespace ballservo
