// Rendered frames with exact truth for the benchmark.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/color/color_table.hpp"

namespace ballservo::bench {

struct BenchFrame {
  cv::Mat bgr;
  OutlineEllipse truth;
  Eigen::Vector3d p_CB;
};

/// One size's frames: a shaded red ball of 70 mm at 1 m before a cluttered room, noise of 2 grey levels, 0.7
/// px of blur; a new scene each.
struct BenchSet {
  std::shared_ptr<const RayTable> rays;
  std::shared_ptr<const ColorTable> colors;
  std::vector<BenchFrame> frames;
};

constexpr double ball_radius_m = 0.035;

/// What is in the scenes besides: balls like the first one, apart from each other, and boxes of nearly their
/// colour behind them.
struct BenchCrowd {
  int balls = 1, more_boxes = 0;
};

/// `focal_px` sets the ball's size: 2 * 0.035 * focal_px pixels across. The truth is that of the first ball.
BenchSet make_frames(ImageSize size, double focal_px, int count, const BenchCrowd& crowd = {});

}  // namespace ballservo::bench
