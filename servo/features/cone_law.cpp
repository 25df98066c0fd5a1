#include "servo/features/cone_law.hpp"

#include <cmath>

namespace ballservo {

namespace {
// Where the azimuth or the logarithm means nothing: the ball's centre (nearly) straight above or below the
// camera.
constexpr double min_level_distance_m = 1e-6;
constexpr double max_distance_m = 1e6;

bool has_features(const Eigen::Vector3d& q) {
  return q.allFinite() && std::hypot(q.x(), q.y()) > min_level_distance_m && q.norm() < max_distance_m;
}
}  // namespace

ConeLaw::ConeLaw(const LawOptions& options, const ServoGoal& goal)
    : gain_per_s_(options.gain_per_s), lever_m_(goal.mount.forward_m), R_RC_(goal.mount.X_RC().linear()) {
  const Eigen::Vector3d q = R_RC_ * goal.desired_p_CB();
  rho_desired_m_ = q.norm();
  azimuth_desired_rad_ = std::atan2(q.y(), q.x());
}

std::optional<Eigen::Vector2d> ConeLaw::errors(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d q = R_RC_ * p_CB;
  if (!has_features(q)) return std::nullopt;
  return Eigen::Vector2d(std::log(q.norm() / rho_desired_m_),
                         wrap_angle(std::atan2(q.y(), q.x()) - azimuth_desired_rad_));
}

std::optional<Eigen::Matrix2d> ConeLaw::robot_jacobian(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d q = R_RC_ * p_CB;
  if (!has_features(q)) return std::nullopt;
  const double a = q.x(), b = q.y(), l = lever_m_;
  const double rho2 = q.squaredNorm(), r2 = a * a + b * b;
  Eigen::Matrix2d J;
  J << -a / rho2, -l * b / rho2,  //
      b / r2, -(1.0 + l * a / r2);
  return J;
}

std::optional<Eigen::Matrix<double, 2, 3>> ConeLaw::ball_jacobian(const Eigen::Vector3d& p_CB) const {
  const Eigen::Vector3d q = R_RC_ * p_CB;
  if (!has_features(q)) return std::nullopt;
  const double r2 = q.x() * q.x() + q.y() * q.y();
  Eigen::Matrix<double, 2, 3> L_R;  // by q
  L_R.row(0) = q.transpose() / q.squaredNorm();
  L_R.row(1) = Eigen::RowVector3d(-q.y() / r2, q.x() / r2, 0.0);
  return L_R * R_RC_;
}

std::optional<LawOutput> ConeLaw::command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) {
  if (!((R_RC_ * p_CB).x() + lever_m_ >= min_ahead_m)) return std::nullopt;
  return decaying(*this, gain_per_s_, p_CB, v_CB);
}

}  // namespace ballservo
