// Range and bearing of the ball in the floor plane.
#pragma once

#include "servo/features/ball_feature.hpp"

namespace ballservo {

/// Cylindrical coordinates of the ball's centre in the robot frame: s = (range, bearing, height), with
/// p_RB = X_RC p_CB = (x, y, z) and r^2 = x^2 + y^2: range r (m), bearing atan2(y, x) (rad), height z (m).
///
/// Position-based visual servoing (Chaumette and Hutchinson, "Visual servo control, part I", IEEE RAM 13(4),
/// 2006): the image is turned into metres first, so an error of the ball's diameter, of the focal length or
/// of the mount moves the place where the robot stops, unless the goal was taught by showing.
///
///             [ x / r     y / r    0 ]
///     ds/dq = [ -y / r^2  x / r^2  0 ]
///             [ 0         0        1 ],
///
/// not defined for a centre straight above the axle's middle (r = 0).
///
/// For a robot on the floor x' = -v + w y and y' = -w x: the lever arm and the pitch are in X_RC, not in the
/// matrix,
///
///     [range'  ]   [ -x/r     0 ] [v]
///     [bearing'] = [  y/r^2  -1 ] [w],      det = x / r,
///
/// singular exactly when the ball is abeam of the axle (x = 0). Without delay errors decay from everywhere
/// ahead of it, range in a straight exponential where the other features' forward error is a logarithm or
/// counted along an axis.
class FloorFeature final : public BallFeature {
 public:
  explicit FloorFeature(const Eigen::Isometry3d& X_RC);

  static unsigned int selectRange() { return FEATURE_LINE[0]; }
  static unsigned int selectBearing() { return FEATURE_LINE[1]; }
  static unsigned int selectHeight() { return FEATURE_LINE[2]; }

  FloorFeature* duplicate() const override { return new FloorFeature(*this); }

 private:
  const char* name() const override { return "FloorFeature (range, bearing, height): "; }
  bool defined(const Eigen::Vector3d& p_RB) const override;
  Eigen::Vector3d coordinates(const Eigen::Vector3d& p_RB, Eigen::Matrix3d& derivative) const override;
};

}  // namespace ballservo
