#include "perception/outline/ball_position.hpp"

#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

Eigen::Vector3d paper_position(const UndistortedCircle& circle, double focal_px, double radius_m) {
  const double z = radius_m * std::sqrt(1 + std::pow(focal_px / circle.radius_px, 2));
  return {circle.center_px.x() * z / focal_px, circle.center_px.y() * z / focal_px, z};
}

Eigen::Matrix3d paper_position_jacobian(const UndistortedCircle& circle, double focal_px, double radius_m) {
  const Eigen::Vector3d p = paper_position(circle, focal_px, radius_m);
  const double z_by_radius =
      -radius_m * radius_m * focal_px * focal_px / (std::pow(circle.radius_px, 3) * p.z());
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  jacobian(0, 0) = jacobian(1, 1) = p.z() / focal_px;
  jacobian.col(2) =
      Eigen::Vector3d(circle.center_px.x() / focal_px, circle.center_px.y() / focal_px, 1) * z_by_radius;
  return jacobian;
}

std::optional<TangentCone> cone_near_circle(const UndistortedCircle& circle, double focal_px) {
  constexpr int count = 16;
  Eigen::Matrix<double, 3, count> rays;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    const Eigen::Vector2d p =
        circle.center_px + circle.radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    rays.col(i) = Eigen::Vector3d(p.x(), p.y(), focal_px).normalized();
  }
  const auto center = sphere_from_rays(rays, 1);
  if (!center) return std::nullopt;
  return TangentCone::of_sphere(*center, 1);
}

}  // namespace ballservo
