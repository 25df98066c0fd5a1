// The law after Fomena and Chaumette: the ball's centre in units of its own radius.
#pragma once

#include "servo/features/feature_law.hpp"

namespace ballservo {

/// Features: the first two of q / R, the ball's centre in units of its radius R, levelled: q = R_RC p_CB =
/// (a, b, c) as seen from the camera, along the robot's axes (ahead, left, up). error_1 = (a - a*) / R,
/// error_2 = (b - b*) / R.
///
/// Fomena and Chaumette ("Improvements on visual servoing from spherical targets using a spherical projection
/// model", IEEE T-RO 25(4), 2009) take the direction of the centre on the unit sphere over the radius of the
/// ball's image there, which is the centre over R, and find it linked linearly to the camera's translation:
/// s' = -(1/R) v + s x w. A robot on the floor has two velocities, so that it can serve two of the three.
/// Levelled, the third (up) never changes, whatever the robot does: it says nothing, and the other two say
/// all. Without the levelling the pitch would mix it into the forward feature. R is the radius that
/// perception believes: p_CB / R is of the image alone.
///
/// With l the camera's distance ahead of the axle, a ball at rest moves by a' = -v + w b, b' = -w (a + l), so
/// that
///
///     [error_1']   [ -1/R    b/R        ] [v]
///     [error_2'] = [   0    -(a + l)/R  ] [w],      det = (a + l) / R^2
///
/// singular exactly when the ball is abeam of the axle. Without delay errors decay from everywhere ahead of
/// it; a wrong R multiplies the speeds only, which moves no equilibrium: stable while R_believed/R is
/// below 2. For delay see max_stable_gain_per_s.
class SphereLaw final : public FeatureLaw {
 public:
  /// Options and goal as LawCatalog::make has checked them.
  SphereLaw(const LawOptions& options, const ServoGoal& goal);

  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override;
  std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const override;

 private:
  double gain_per_s_, lever_m_, radius_m_;
  Eigen::Matrix3d R_RC_;
  Eigen::Vector2d desired_;
};

}  // namespace ballservo
