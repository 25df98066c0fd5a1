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

/// How the search for round coloured regions goes.
struct RegionSearchOptions {
  double min_radius_px = 4.5;       ///< at the working scale
  double sure_radius_px = 8;        ///< smaller ones must be rounder: a few pixels of anything are round
  double max_working_pixels = 1e6;  ///< larger pictures are searched at a reduced scale
  std::uint64_t seed = 0;           ///< of the circle votes
  std::function<void()> before_each_test{};  ///< of a region's roundness; what it throws ends the search
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
/// that stand out where any does. `bgr` is CV_8UC3. Throws InputError for a picture of another type.
RoundRegions find_round_regions(const cv::Mat& bgr, const RegionSearchOptions& search = {});

}  // namespace ballservo
