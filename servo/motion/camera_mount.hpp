// How the camera sits on the robot, and how it turns there.
#pragma once

#include <Eigen/Geometry>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// A pan turns the camera to the left and to the right, about the vertical through its optical centre. The
/// speed is that of the Canon VC-C4 on the Pioneers; the acceleration is an assumption.
struct PanLimits {
  double max_rad = 0;  ///< to either side of straight ahead; 0: the camera does not turn
  double speed_max_radps = 1.57;
  double acceleration_max_radps2 = 6;

  bool turns() const { return max_rad > 0; }
};

/// Of a drive that turns on the spot as the pan turns.
UnicycleLimits drive_limits(const PanLimits& pan);

/// Where the pan stands, left positive, 0 straight ahead; and how fast it turns.
struct PanMotion {
  double angle_rad = 0, speed_radps = 0;
};

/// The camera looks along the robot's middle plane where it is not turned, pitched down; level for a pitch of
/// 0.
struct CameraMount {
  double forward_m = 0.10;       ///< ahead of the axle
  double up_m = 0.28;            ///< over the floor
  double pitch_down_rad = 0.21;  ///< of the optical axis below the horizon
  PanLimits pan{};

  /// The camera frame (x right, y down, z forward) in the robot frame (x forward, y left, z up).
  Eigen::Isometry3d X_RC(double pan_rad = 0) const;
};
void declare(OptionVisitor& v, CameraMount& mount);

}  // namespace ballservo
