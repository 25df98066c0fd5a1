#include "servo/avoidance/floor_region.hpp"

#include <limits>

namespace ballservo {

FloorRegion::Span FloorRegion::at(double y_m) const {
  constexpr double far = std::numeric_limits<double>::infinity();
  Span span{-far, far};
  if (disc_radius_m > 0.0) {
    const double dy = y_m - disc_y_m, left = disc_radius_m * disc_radius_m - dy * dy;
    if (left < 0.0) return {1.0, -1.0};
    const double half = std::sqrt(left);
    span = {disc_x_m - half, disc_x_m + half};
  }
  for (int k = 0; k < plane_count; ++k) {
    const HalfPlane& plane = planes[static_cast<std::size_t>(k)];
    const double rest = plane.c - plane.ny * y_m;
    if (plane.nx > 1e-12) {
      span.high_m = std::min(span.high_m, rest / plane.nx);
    } else if (plane.nx < -1e-12) {
      span.low_m = std::max(span.low_m, rest / plane.nx);
    } else if (rest < 0.0) {
      return {1.0, -1.0};
    }
  }
  return span;
}

FloorRegion FloorRegion::around(const Footprint& footprint, const Pose2& pose, double margin_m) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const double front_m = footprint.front_m + margin_m, rear_m = footprint.rear_m + margin_m;
  const double side_m = footprint.half_width_m + margin_m;
  FloorRegion region;
  region.add(c, s, pose.x_m + c * front_m, pose.y_m + s * front_m);
  region.add(-c, -s, pose.x_m - c * rear_m, pose.y_m - s * rear_m);
  region.add(-s, c, pose.x_m - s * side_m, pose.y_m + c * side_m);
  region.add(s, -c, pose.x_m + s * side_m, pose.y_m - c * side_m);
  const double up_m = std::max(s * front_m, -s * rear_m) + std::abs(c) * side_m;
  const double down_m = std::max(-s * front_m, s * rear_m) + std::abs(c) * side_m;
  region.y_low_m = pose.y_m - down_m;
  region.y_high_m = pose.y_m + up_m;
  return region;
}

FloorRegion FloorRegion::disc(double x_m, double y_m, double radius_m) {
  FloorRegion region;
  region.disc_x_m = x_m;
  region.disc_y_m = y_m;
  region.disc_radius_m = radius_m;
  region.y_low_m = y_m - radius_m;
  region.y_high_m = y_m + radius_m;
  return region;
}

FloorRegion FloorRegion::cone(const Pose2& transducer, double half_angle_rad, double radius_m,
                              double outwards_m) {
  const double right = transducer.yaw_rad - half_angle_rad, left = transducer.yaw_rad + half_angle_rad;
  FloorRegion region = disc(transducer.x_m, transducer.y_m, radius_m);
  const auto side = [&](double nx, double ny) {
    region.add(nx, ny, transducer.x_m + outwards_m * nx, transducer.y_m + outwards_m * ny);
  };
  side(std::sin(right), -std::cos(right));
  side(-std::sin(left), std::cos(left));
  region.add(-std::cos(transducer.yaw_rad), -std::sin(transducer.yaw_rad), transducer.x_m, transducer.y_m);
  return region;
}

}  // namespace ballservo
