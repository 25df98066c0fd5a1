#include "servo/motion/mount.hpp"

#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

Eigen::Isometry3d CameraMount::X_RC() const {
  const double c = std::cos(pitch_down_rad), s = std::sin(pitch_down_rad);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(forward_m, 0.0, up_m);
  X.linear().col(0) = Eigen::Vector3d(0, -1, 0);   // camera right
  X.linear().col(1) = Eigen::Vector3d(-s, 0, -c);  // camera down
  X.linear().col(2) = Eigen::Vector3d(c, 0, -s);   // camera forward
  return X;
}

void declare(OptionVisitor& v, CameraMount& mount) {
  v.number("forward_m", mount.forward_m, NumberRange::within(-1, 1, "m"), "camera ahead of the axle",
           required);
  v.number("up_m", mount.up_m, NumberRange::above(0, 3, "m"), "camera over the floor", required);
  v.number("pitch_down_rad", mount.pitch_down_rad, NumberRange::within(-1.5707, 1.5707, "rad"),
           "optical axis below the horizon", required);
}

}  // namespace ballservo
