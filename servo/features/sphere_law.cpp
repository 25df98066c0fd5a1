#include "servo/features/sphere_law.hpp"

namespace ballservo {

namespace {
constexpr double max_distance_m = 1e6;

bool has_features(const Eigen::Vector3d& q) { return q.allFinite() && q.norm() < max_distance_m; }
}  // namespace

SphereLaw::SphereLaw(const LawOptions& options, const ServoGoal& goal)
    : gain_per_s_(options.gain_per_s),
      lever_m_(goal.mount.forward_m),
      radius_m_(goal.ball_radius_m),
      R_RC_(goal.mount.X_RC().linear()),
      desired_((R_RC_ * goal.desired_p_CB()).head<2>() / radius_m_) {}

std::optional<Eigen::Vector2d> SphereLaw::errors(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d q = R_RC_ * p_CB;
  if (!has_features(q)) return std::nullopt;
  return Eigen::Vector2d(q.head<2>() / radius_m_ - desired_);
}

std::optional<Eigen::Matrix2d> SphereLaw::robot_jacobian(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d q = R_RC_ * p_CB;
  if (!has_features(q)) return std::nullopt;
  Eigen::Matrix2d J;
  J << -1.0, q.y(),  //
      0.0, -(q.x() + lever_m_);
  return Eigen::Matrix2d(J / radius_m_);
}

std::optional<Eigen::Matrix<double, 2, 3>> SphereLaw::ball_jacobian(const Eigen::Vector3d& p_CB) const {
  if (!has_features(R_RC_ * p_CB)) return std::nullopt;
  return Eigen::Matrix<double, 2, 3>(R_RC_.topRows<2>() / radius_m_);
}

std::optional<LawOutput> SphereLaw::command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) {
  if (!((R_RC_ * p_CB).x() + lever_m_ >= min_ahead_m)) return std::nullopt;
  return decaying(*this, gain_per_s_, p_CB, v_CB);
}

}  // namespace ballservo
