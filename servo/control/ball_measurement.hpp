// What the servo side is told about the ball, frame by frame; it does not know who looked.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "calibration/base/track_state.hpp"

namespace ballservo {

/// One frame's word on the target ball.
struct BallMeasurement {
  double time_s = -std::numeric_limits<double>::infinity();  ///< middle of the exposure, the robot's clock
  TrackState state = TrackState::none;  ///< `none`: no ball, which still shows that the camera is alive
  Eigen::Vector3d p_CB{0, 0, 0};  ///< centre of the ball in the camera frame (m); means nothing for `none`
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of p_CB (m^2)
  double pan_rad = 0;                                       ///< the camera was turned so far to the left

  /// Was it seen, not only predicted?
  bool is_sighting() const { return state == TrackState::tentative || state == TrackState::confirmed; }
};

}  // namespace ballservo
