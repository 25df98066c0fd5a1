// The position-based law, to compare the others with.
#pragma once

#include "servo/features/feature_law.hpp"

namespace ballservo {

/// Features: range and bearing of the ball as seen from the axle, in the floor plane: with p_RB = X_RC p_CB =
/// (x, y, .) and r^2 = x^2 + y^2, error_1 = r - r* (m), error_2 = atan2(y, x) - atan2(y*, x*) (rad).
/// Position-based visual servoing (Chaumette and Hutchinson, "Visual servo control, part I", IEEE RAM 13(4),
/// 2006): the image is turned into metres first, so an error of the ball's diameter, of the focal length or
/// of the mount moves the place where the robot stops, unless the goal was taught by showing.
///
/// A ball at rest moves by x' = -v + w y, y' = -w x. The lever arm and the pitch are in X_RC, not in the
/// matrix:
///
///     [error_1']   [ -x/r     0 ] [v]
///     [error_2'] = [  y/r^2  -1 ] [w],      det = x / r
///
/// singular exactly when the ball is abeam of the axle (x = 0). Without delay errors decay from everywhere
/// ahead of it, range in a straight exponential where the other laws' forward error is a logarithm or counted
/// along an axis. For delay see max_stable_gain_per_s.
class PoseLaw final : public FeatureLaw {
 public:
  /// Options and goal as LawCatalog::make has checked them.
  PoseLaw(const LawOptions& options, const ServoGoal& goal);

  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override;
  std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const override;

 private:
  double gain_per_s_;
  Eigen::Isometry3d X_RC_;
  double range_desired_m_, bearing_desired_rad_;
};

}  // namespace ballservo
