#include "servo/avoidance/floor_scan.hpp"

#include <cmath>

namespace ballservo {

namespace {
constexpr double wide_at_m = 1.0, nearest_floor_m = 0.05, scan_step_m = 0.01;
}  // namespace

FloorFan::FloorFan(const Camera& camera, const CameraMount& mount, double reach_m)
    : camera_(camera), mount_(mount), X_CR_(mount.X_RC().inverse()), reach_m_(reach_m) {
  const double at_m = std::min(wide_at_m, reach_m);
  double half_rad = 0;
  while (half_rad < 1.5 && pixel(half_rad + 0.01, at_m) && pixel(-half_rad - 0.01, at_m)) half_rad += 0.01;
  for (std::size_t k = 0; k < FloorScan::max_rays; ++k) {
    const double bearing = half_rad * (2.0 * static_cast<double>(k) / (FloorScan::max_rays - 1) - 1.0);
    double from_m = reach_m;
    while (from_m - scan_step_m > nearest_floor_m && pixel(bearing, from_m - scan_step_m))
      from_m -= scan_step_m;
    if (from_m < reach_m) rays_.push_back({bearing, from_m});
  }
}

std::optional<Eigen::Vector2d> FloorFan::pixel(double bearing_rad, double range_m) const {
  const Eigen::Vector3d p_R(mount_.forward_m + range_m * std::cos(bearing_rad),
                            range_m * std::sin(bearing_rad), 0.0);
  const auto pixel = camera_.project(X_CR_ * p_R);
  return pixel && is_inside_picture(*pixel, camera_.size(), 0.5) ? pixel : std::nullopt;
}

double FloorFan::metres_per_pixel(double range_m) const {
  return (range_m * range_m + mount_.up_m * mount_.up_m) / (mount_.up_m * camera_.focal_px());
}

}  // namespace ballservo
