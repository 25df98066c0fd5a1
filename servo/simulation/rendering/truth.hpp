// What is exactly true of every ball in a frame.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

struct BallTruth {
  std::string name, class_name;
  Eigen::Vector3d p_CB{0, 0, 0};          ///< centre in the camera frame (m)
  std::optional<OutlineEllipse> outline;  ///< nothing where the outline cannot be projected
  /// Fraction of the outline's area that the camera sees: inside the picture and not behind anything. 0
  /// without an outline.
  double visible_fraction = 0;
  bool center_in_view = false;  ///< the centre's image lies inside the picture
};

/// One entry per ball of the world, in its order. Exact; the visible fraction of a partly hidden ball to
/// about 0.002, of one that is wholly seen or hidden exactly 1 or 0.
std::vector<BallTruth> ball_truth(const Camera& camera, const World& world, const CameraView& view);
/// Of one ball alone.
BallTruth ball_truth(const Camera& camera, const World& world, const CameraView& view, std::size_t index);

/// Where ball `index` hides what is behind it, or would: CV_8UC1 of the camera's size, 0 where something
/// stands nearer than the ball's middle, and outside `box` (px), which bounds the cost.
cv::Mat unhidden_pixels(const Camera& camera, const World& world, const CameraView& view, std::size_t index,
                        const cv::Rect& box);

}  // namespace ballservo
