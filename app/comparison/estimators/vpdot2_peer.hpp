// ViSP's blob tracker as its users start it: with a click on the ball.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "app/comparison/estimators/opencv_peers.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

/// What it is started on, and how round a blob must be.
struct VpDot2Settings {
  bool mask = true;         ///< the picture of the ball's hue (see hsv_mask) instead of the grey one
  double roundness = 0.65;  ///< setEllipsoidShapePrecision: 0 takes any shape
  HsvSettings hsv{80, 30};
};

/// The blob (vpDot2) around a clicked pixel: its centre of gravity, and the radius of a disc of its area.
/// Nothing where the tracker refuses.
std::optional<OutlineEllipse> vpdot2_blob(const cv::Mat& bgr, int hue, const Eigen::Vector2d& click_px,
                                          const VpDot2Settings& settings);

}  // namespace ballservo
