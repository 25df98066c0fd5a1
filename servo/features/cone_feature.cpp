#include "servo/features/cone_feature.hpp"

#include <cmath>

namespace ballservo {

ConeFeature::ConeFeature(const Eigen::Matrix3d& R_FC)
    : BallFeature(Eigen::Isometry3d(R_FC), MiddleRow::angle) {}

bool ConeFeature::defined(const Eigen::Vector3d& q) const {
  constexpr double min_level_distance_m = 1e-6;
  return std::hypot(q.x(), q.y()) > min_level_distance_m;
}

Eigen::Vector3d ConeFeature::coordinates(const Eigen::Vector3d& q, Eigen::Matrix3d& derivative) const {
  const double a = q.x(), b = q.y(), c = q.z();
  const double rho2 = q.squaredNorm(), r2 = a * a + b * b, r = std::sqrt(r2);
  derivative << a / rho2, b / rho2, c / rho2,  //
      -b / r2, a / r2, 0,                      //
      -a * c / (r * rho2), -b * c / (r * rho2), r / rho2;
  return {std::log(q.norm()), std::atan2(b, a), std::atan2(c, r)};
}

}  // namespace ballservo
