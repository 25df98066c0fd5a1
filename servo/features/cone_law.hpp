// The default law: what the ball's tangent cone shows, levelled.
#pragma once

#include "servo/features/feature_law.hpp"

namespace ballservo {

/// Features: error_1 = log(rho / rho*), rho = |p_CB|, and error_2 = theta - theta*, the azimuth of the ball's
/// centre as the camera would see it were it level (rad, positive to the left).
///
/// Both are functions of C/R alone, so of the image alone: rho/R = 1/sin(alpha) for the half angle alpha of
/// the cone that touches the ball, so log(rho/rho*) = log(sin alpha* / sin alpha), and the azimuth is that of
/// the cone's axis.
///
/// With q = R_RC p_CB = (a, b, .) (camera's place, robot's axes), l the camera's distance ahead of the axle
/// and r^2 = a^2 + b^2, a ball at rest moves by a' = -v + w b, b' = -w (a + l), so that
///
///     [rho'/rho ]   [ -a / rho^2   -l b / rho^2      ] [v]
///     [theta'   ] = [  b / r^2     -(1 + l a / r^2)  ] [w],      det = (a + l) / rho^2
///
/// singular exactly when the ball is abeam of the axle (a + l = 0). The levelling by R_RC takes the place of
/// the rotation that spherical-projection features allow (Fomena and Chaumette, "Improvements on visual
/// servoing from spherical targets using a spherical projection model", T-RO 2009: depth and direction
/// decouple there, as here).
class ConeLaw final : public FeatureLaw {
 public:
  /// Options and goal as LawCatalog::make has checked them.
  ConeLaw(const LawOptions& options, const ServoGoal& goal);

  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override;
  std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const override;

 private:
  double gain_per_s_, lever_m_, rho_desired_m_, azimuth_desired_rad_;
  Eigen::Matrix3d R_RC_;
};

}  // namespace ballservo
