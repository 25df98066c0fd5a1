// How the camera sits on the robot.
#pragma once

#include <Eigen/Geometry>

namespace ballservo {

class OptionVisitor;

/// The camera looks ahead, in the robot's middle plane, pitched down; level for a pitch of 0.
struct CameraMount {
  double forward_m = 0.10;       ///< ahead of the axle
  double up_m = 0.28;            ///< over the floor
  double pitch_down_rad = 0.21;  ///< of the optical axis below the horizon

  /// The camera frame (x right, y down, z forward) in the robot frame (x forward, y left, z up).
  Eigen::Isometry3d X_RC() const;
};
void declare(OptionVisitor& v, CameraMount& mount);

}  // namespace ballservo
