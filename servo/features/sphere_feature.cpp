#include "servo/features/sphere_feature.hpp"

namespace ballservo {

SphereFeature::SphereFeature(double radius_m, const Eigen::Matrix3d& R_FC)
    : BallFeature(Eigen::Isometry3d(R_FC), MiddleRow::length), radius_m_(radius_m) {}

Eigen::Vector3d SphereFeature::coordinates(const Eigen::Vector3d& q, Eigen::Matrix3d& derivative) const {
  derivative = Eigen::Matrix3d::Identity() / radius_m_;
  return q / radius_m_;
}

}  // namespace ballservo
