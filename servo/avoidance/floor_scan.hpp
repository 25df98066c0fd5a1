// What a frame of the camera says of the floor ahead (servo/ does not know who looked), and in which
// directions a camera looks.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "servo/motion/camera_mount.hpp"

namespace ballservo {

/// Along one direction over the floor, from under the camera outwards (m): floor is seen from `from_m` to
/// `clear_m`; from there to `until_m` it is not: something stands there, or hides what lies behind. Where
/// nothing stands within reach both are the reach.
struct FloorRay {
  double bearing_rad = 0;  ///< in the robot frame, left positive
  double from_m = 0, clear_m = 0, until_m = 0;
};

/// Whether a ray's numbers can be: what others say of the floor is not taken on trust.
inline bool is_sane(const FloorRay& ray) {
  return std::isfinite(ray.bearing_rad) && ray.from_m >= 0.0 && ray.clear_m >= ray.from_m &&
         ray.until_m >= ray.clear_m && ray.until_m < 20.0;
}

/// One frame's. Rays stand in the order of their bearings.
struct FloorScan {
  static constexpr std::size_t max_rays = 64;
  double time_s = -std::numeric_limits<double>::infinity();  ///< middle of the exposure, the robot's clock
  double camera_forward_m = 0;                               ///< the camera ahead of the axle
  std::array<FloorRay, max_rays> rays{};
  std::size_t count = 0;  ///< of rays; 0: nothing could be said
};

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
