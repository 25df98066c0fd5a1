// A ball that moved while the shutter was open: its light is spread along its way, its outline is a
// capsule's.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "calibration/camera/camera.hpp"
#include "perception/ball_observation.hpp"
#include "perception/outline/camera_response.hpp"

namespace ballservo {

/// A capsule in the picture (px).
struct Streak {
  Eigen::Vector2d center_px{0, 0};  ///< of the ball at the middle of the exposure
  Eigen::Vector2d way_px{0, 0};     ///< the middle line from end to end
  double half_width_px = 0;         ///< the ball's radius
  /// How much of what differs from the background is a disc of the ball's colour, moved at a constant speed:
  /// a share of the sum of squares.
  double explained = 0;
};

/// The streak near an expected one, of a ball whose own colour is `ball_bgr` (grey levels). A pixel is
/// covered for a part of the exposure. These parts have the moments of a disc and a line: centre, way and
/// width follow from them. The background is what lies on both sides. Nothing where the picture leaves it.
std::optional<Streak> measure_streak(const cv::Mat& bgr, const CameraResponse& response,
                                     const Eigen::Vector3d& ball_bgr, const Streak& expected);

/// The ball that makes such a streak: it is where it was at the middle of the exposure. Nothing where there
/// is no streak of the expected ball.
std::optional<BallObservation> find_streak(const cv::Mat& bgr, const Camera& camera,
                                           const CameraResponse& response, const Eigen::Vector3d& ball_bgr,
                                           const Streak& expected, const BallRadius& radius);

}  // namespace ballservo
