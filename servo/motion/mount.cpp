#include "servo/motion/mount.hpp"

#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

namespace {
std::string shown(double value) { return std::isnan(value) ? "NaN" : number_text(value); }
}  // namespace

Eigen::Isometry3d CameraMount::X_RC() const {
  const double c = std::cos(pitch_down_rad), s = std::sin(pitch_down_rad);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(forward_m, 0.0, up_m);
  X.linear().col(0) = Eigen::Vector3d(0, -1, 0);   // camera right
  X.linear().col(1) = Eigen::Vector3d(-s, 0, -c);  // camera down
  X.linear().col(2) = Eigen::Vector3d(c, 0, -s);   // camera forward
  return X;
}

void CameraMount::validate() const {
  FaultList faults;
  if (!std::isfinite(forward_m)) faults.add("mount.forward_m", shown(forward_m), "a number (m)");
  if (!std::isfinite(up_m) || up_m <= 0.0) faults.add("mount.up_m", shown(up_m), "a number above 0 (m)");
  if (!(std::abs(pitch_down_rad) <= 1.5707963267948966)) {
    faults.add("mount.pitch_down_rad", shown(pitch_down_rad), "a number from -1.5708 to 1.5708 (rad)");
  }
  faults.throw_if_any();
}

}  // namespace ballservo
