#include "servo/features/floor_feature.hpp"

#include <cmath>

namespace ballservo {

FloorFeature::FloorFeature(const Eigen::Isometry3d& X_RC) : BallFeature(X_RC, MiddleRow::angle) {}

bool FloorFeature::defined(const Eigen::Vector3d& p_RB) const {
  constexpr double min_range_m = 1e-6;
  return std::hypot(p_RB.x(), p_RB.y()) > min_range_m;
}

Eigen::Vector3d FloorFeature::coordinates(const Eigen::Vector3d& p_RB, Eigen::Matrix3d& derivative) const {
  const double x = p_RB.x(), y = p_RB.y(), r2 = x * x + y * y, r = std::hypot(x, y);
  derivative << x / r, y / r, 0,  //
      -y / r2, x / r2, 0,         //
      0, 0, 1;
  return {r, std::atan2(y, x), p_RB.z()};
}

}  // namespace ballservo
