// A law on two features of the ball's centre whose derivatives it knows.
#pragma once

#include "servo/control/law.hpp"

namespace ballservo {

/// A control law on two features of the ball's centre. Its features must not depend on how the floor is
/// turned.
class FeatureLaw : public Law {
 public:
  /// The two errors alone; nothing where the features are undefined.
  virtual std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const = 0;

  /// Robot Jacobian J (2 x 2): derivative of the errors by time, per (v, w), for a ball that rests.
  virtual std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const = 0;

  /// Interaction with the ball's own motion L (2 x 3): derivative of the errors by p_CB.
  virtual std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const = 0;
};

/// The twist that lets a law's errors decay at `gain_per_s`: u = J^-1 (-lambda e - L v_CB), by Cramer's rule.
/// Nothing where the features are undefined, the Jacobian is singular, or the twist is not finite.
std::optional<LawOutput> decaying(const FeatureLaw& law, double gain_per_s, const Eigen::Vector3d& p_CB,
                                  const Eigen::Vector3d& v_CB);

}  // namespace ballservo
