#include "servo/features/pose_law.hpp"

#include <cmath>

namespace ballservo {

namespace {
constexpr double min_range_m = 1e-6, max_range_m = 1e6;

bool has_features(const Eigen::Vector3d& p_RB) {
  const double range_m = std::hypot(p_RB.x(), p_RB.y());
  return p_RB.allFinite() && range_m > min_range_m && range_m < max_range_m;
}
}  // namespace

PoseLaw::PoseLaw(const LawOptions& options, const ServoGoal& goal)
    : gain_per_s_(options.gain_per_s), X_RC_(goal.mount.X_RC()) {
  const Eigen::Vector3d p_RB = X_RC_ * goal.desired_p_CB();
  range_desired_m_ = std::hypot(p_RB.x(), p_RB.y());
  bearing_desired_rad_ = std::atan2(p_RB.y(), p_RB.x());
}

std::optional<Eigen::Vector2d> PoseLaw::errors(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d p_RB = X_RC_ * p_CB;
  if (!has_features(p_RB)) return std::nullopt;
  return Eigen::Vector2d(std::hypot(p_RB.x(), p_RB.y()) - range_desired_m_,
                         wrap_angle(std::atan2(p_RB.y(), p_RB.x()) - bearing_desired_rad_));
}

std::optional<Eigen::Matrix2d> PoseLaw::robot_jacobian(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d p_RB = X_RC_ * p_CB;
  if (!has_features(p_RB)) return std::nullopt;
  const double r2 = p_RB.head<2>().squaredNorm();
  Eigen::Matrix2d J;
  J << -p_RB.x() / std::sqrt(r2), 0.0,  //
      p_RB.y() / r2, -1.0;
  return J;
}

std::optional<Eigen::Matrix<double, 2, 3>> PoseLaw::ball_jacobian(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d p_RB = X_RC_ * p_CB;
  if (!has_features(p_RB)) return std::nullopt;
  const double x = p_RB.x(), y = p_RB.y(), r2 = x * x + y * y, r = std::sqrt(r2);
  Eigen::Matrix<double, 2, 3> L_R;  // by p_RB
  L_R << x / r, y / r, 0.0,         //
      -y / r2, x / r2, 0.0;
  return Eigen::Matrix<double, 2, 3>(L_R * X_RC_.linear());
}

std::optional<LawOutput> PoseLaw::command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) {
  if (!((X_RC_ * p_CB).x() >= min_ahead_m)) return std::nullopt;
  return decaying(*this, gain_per_s_, p_CB, v_CB);
}

}  // namespace ballservo
