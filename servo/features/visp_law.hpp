// The reference law: ViSP's vpServo on a point and its depth.
#pragma once

#include <memory>

#include "servo/features/feature_law.hpp"

namespace ballservo {

/// Features: error_1 = x - x*, x = X/Z of the ball's centre (vpFeaturePoint), and error_2 = log(Z / Z*)
/// (vpFeatureDepth), in vpServo's EYEINHAND_L_cVe_eJe with the current interaction matrix; the mount's pitch
/// and lever arm enter through cVe (of X_CR) and eJe (of a unicycle: v along the robot's x, w about its z).
/// In closed form, with s and c the sine and cosine of the pitch and l the camera's distance ahead of the
/// axle,
///
///     [x'          ]   [ c x / Z   (1 + x^2) c - y s + l / Z ] [v]
///     [(log Z)'    ] = [ -c / Z    -x c                      ] [w],    det = c X_R / Z^2,
///
/// singular exactly when the ball is abeam of the axle (X_R = Z (c - y s) + l = 0), and undefined for Z <= 0.
/// vpServo allocates memory in every step.
class VispLaw final : public FeatureLaw {
 public:
  /// Options and goal as LawCatalog::make has checked them; InputError where the goal lies behind the camera.
  VispLaw(const LawOptions& options, const ServoGoal& goal);
  ~VispLaw() override;

  std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) override;
  std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const override;
  /// From ViSP's own interaction matrices, cVe and eJe.
  std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const override;
  std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ballservo
