// The round coloured regions of a picture: what colour calibration takes for balls (paper, "Calibrage",
// 2a-b).
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/circles/circle_evidence.hpp"

namespace ballservo {

/// How the search for round coloured regions goes.
struct RegionSearchOptions {
  double min_radius_px = 4.5;                ///< at the working scale
  double max_working_pixels = 1e6;           ///< larger pictures are searched at a reduced scale
  std::function<void()> before_each_test{};  ///< of a circle; what it throws ends the search
  std::function<void(std::size_t)> before_each_picture{};  ///< of several, with its index
};

/// A region that may be a ball.
struct RoundRegion {
  Eigen::Vector2d center_px{0, 0};  ///< in the picture as given
  double radius_px = 0;
  CircleEvidence evidence;  ///< its circle is that of the working picture
  bool smeared = false;     ///< an ellipse, as motion makes of a ball
  cv::Mat mask;             ///< CV_8U, 255 where the ball's hue is; empty for a disc that the user pointed at
  cv::Point mask_origin;    ///< where the mask's top left pixel lies in the working picture
  double fit_ratio() const { return evidence.arc * evidence.filled; }  ///< near 1 for a whole ball
};

/// What the search saw, and what it found.
struct RoundRegions {
  cv::Mat working;                   ///< the picture as it was searched, CV_8UC3
  double scale = 1;                  ///< working pixels per pixel of the picture, at most 1
  std::vector<RoundRegion> regions;  ///< disjoint, the most likely ball first
};

/// The picture's edges propose circles; the pixels around each circle judge it. A place keeps its most likely
/// region. `bgr` is CV_8UC3. Throws InputError for a picture of another type.
RoundRegions find_round_regions(const cv::Mat& bgr, const RegionSearchOptions& search = {});

}  // namespace ballservo
