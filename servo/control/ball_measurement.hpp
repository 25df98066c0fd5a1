// What the servo side is told about the ball, frame by frame; it does not know who looked.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string_view>

namespace ballservo {

/// What the tracker says of the target in a frame. Only `tentative` and `confirmed` are sightings; `coasting`
/// is a prediction of the tracker's own, `none` a frame without the ball (which still shows that the camera
/// is alive).
enum class TrackState { none, tentative, confirmed, coasting };

/// "none", "tentative", "confirmed", "coasting".
constexpr std::string_view track_state_name(TrackState state) {
  switch (state) {
    case TrackState::tentative:
      return "tentative";
    case TrackState::confirmed:
      return "confirmed";
    case TrackState::coasting:
      return "coasting";
    case TrackState::none:
      break;
  }
  return "none";
}

/// One frame's word on the target ball.
struct BallMeasurement {
  double time_s =
      -std::numeric_limits<double>::infinity();  ///< of the middle of the exposure, on the robot's clock
  TrackState state = TrackState::none;
  Eigen::Vector3d p_CB{0, 0, 0};  ///< centre of the ball in the camera frame (m); means nothing for `none`
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of p_CB (m^2)

  bool is_sighting() const { return state == TrackState::tentative || state == TrackState::confirmed; }
};

}  // namespace ballservo
