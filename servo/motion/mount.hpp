// How the camera sits on the robot.
#pragma once

#include <Eigen/Geometry>

namespace ballservo {

/// The camera looks ahead, in the robot's middle plane, pitched down; level for a pitch of 0.
struct CameraMount {
  double forward_m = 0.10;       ///< ahead of the axle
  double up_m = 0.28;            ///< over the floor
  double pitch_down_rad = 0.21;  ///< of the optical axis below the horizon

  /// The camera frame (x right, y down, z forward) in the robot frame (x forward, y left, z up).
  Eigen::Isometry3d X_RC() const;

  /// Throws InputError naming every value that is not finite, a height that is not above 0, or a pitch beyond
  /// a right angle.
  void validate() const;
};

}  // namespace ballservo
