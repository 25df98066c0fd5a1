#include "servo/motion/camera_mount.hpp"

#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

void declare(OptionVisitor& v, CameraMount& mount) {
  v.number("forward_m", mount.forward_m, NumberRange::within(-1, 1, "m"), "camera ahead of the axle",
           required);
  v.number("up_m", mount.up_m, NumberRange::above(0, 3, "m"), "camera over the floor", required);
  v.number("pitch_down_rad", mount.pitch_down_rad, NumberRange::within(-1.5707, 1.5707, "rad"),
           "optical axis below the horizon", required);
  v.map("pan", [&] {
    PanLimits& pan = mount.pan;
    v.number("max_rad", pan.max_rad, NumberRange::within(0, 3.1415, "rad"),
             "the camera turns so far to either side; 0: it does not");
    v.number("speed_max_radps", pan.speed_max_radps, NumberRange::above(0, 20, "rad/s"), "largest speed");
    v.number("acceleration_max_radps2", pan.acceleration_max_radps2, NumberRange::above(0, 100, "rad/s^2"),
             "acceleration and deceleration");
  });
}

UnicycleLimits drive_limits(const PanLimits& pan) {
  return {1, pan.speed_max_radps, 1, pan.acceleration_max_radps2};
}

Eigen::Isometry3d CameraMount::X_RC(double pan_rad) const {
  const double c = std::cos(pitch_down_rad), s = std::sin(pitch_down_rad);
  const double c_pan = std::cos(pan_rad), s_pan = std::sin(pan_rad);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(forward_m, 0.0, up_m);
  X.linear().col(0) = Eigen::Vector3d(s_pan, -c_pan, 0);            // camera right
  X.linear().col(1) = Eigen::Vector3d(-s * c_pan, -s * s_pan, -c);  // camera down
  X.linear().col(2) = Eigen::Vector3d(c * c_pan, c * s_pan, -s);    // camera forward
  return X;
}

}  // namespace ballservo
