// The directions over the floor in which a camera looks for what stands on it, and where they lie in the
// picture.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "servo/avoidance/floor_scan.hpp"
#include "servo/motion/mount.hpp"

namespace ballservo {

/// Rays over the floor from under the camera, evenly spaced in bearing, as wide as the picture shows the
/// floor at a metre. Bearings and ranges are of the floor plane (m, rad, robot frame's directions).
class FloorFan {
 public:
  /// `reach_m`: nothing further is looked at. None where the picture shows no floor within reach.
  FloorFan(const Camera& camera, const CameraMount& mount, double reach_m);

  struct Ray {
    double bearing_rad = 0, from_m = 0;  ///< from there to the reach the picture shows the floor
  };
  const std::vector<Ray>& rays() const { return rays_; }
  double reach_m() const { return reach_m_; }

  /// Where the floor at that range lies in the picture (px); nothing outside it.
  std::optional<Eigen::Vector2d> pixel(double bearing_rad, double range_m) const;
  /// How far the floor moves (m) for a pixel up or down, at that range: (R^2 + h^2) / (h f).
  double metres_per_pixel(double range_m) const;

 private:
  Camera camera_;
  CameraMount mount_;
  Eigen::Isometry3d X_CR_;
  double reach_m_;
  std::vector<Ray> rays_;
};

}  // namespace ballservo
