#include "servo/features/feature_law.hpp"

namespace ballservo {

std::optional<LawOutput> decaying(const FeatureLaw& law, double gain_per_s, const Eigen::Vector3d& p_CB,
                                  const Eigen::Vector3d& v_CB) {
  const auto e = law.errors(p_CB);
  if (!e) return std::nullopt;
  const Eigen::Matrix2d J = *law.robot_jacobian(p_CB);
  const Eigen::Vector2d rate = -gain_per_s * *e - *law.ball_jacobian(p_CB) * v_CB;
  const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
  const Eigen::Vector2d u((J(1, 1) * rate(0) - J(0, 1) * rate(1)) / det,
                          (J(0, 0) * rate(1) - J(1, 0) * rate(0)) / det);
  if (!u.allFinite()) return std::nullopt;
  return LawOutput{{u(0), u(1)}, (*e)(0), (*e)(1)};
}

}  // namespace ballservo
