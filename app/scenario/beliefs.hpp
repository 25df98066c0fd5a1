// What the robot takes for true, where it is wrong.
#pragma once

#include "calibration/camera/camera.hpp"
#include "servo/motion/camera_mount.hpp"

namespace ballservo {

class OptionVisitor;

/// `believed:` of a scenario: by how much what perception and controller believe differs from how things are.
/// The simulator goes by the truth.
struct Beliefs {
  double focal_scale = 1;      ///< believed focal lengths over the true ones
  double diameter_scale = 1;   ///< believed diameter of the target over the true one
  double pitch_error_rad = 0;  ///< believed less true, of the mount
  double forward_error_m = 0;
  double up_error_m = 0;
  double latency_error_s = 0;  ///< believed less true, of the camera's latency

  Camera camera(const Camera& truth) const;
  CameraMount mount(const CameraMount& truth) const;
  /// Whether what is seen of a ball would be another place by these beliefs.
  bool see_elsewhere() const { return focal_scale != 1 || diameter_scale != 1; }
};

/// A latency that would come out negative is a fault.
void declare(OptionVisitor& v, Beliefs& beliefs, double latency_s);

}  // namespace ballservo
