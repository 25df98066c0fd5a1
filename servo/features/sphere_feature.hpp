// The sphere features of Fomena and Chaumette.
#pragma once

#include "servo/features/ball_feature.hpp"

namespace ballservo {

/// The ball's centre in units of its radius: s = q / R, q = R_FC p_CB.
///
/// Fomena and Chaumette ("Improvements on visual servoing from spherical targets using a spherical projection
/// model", IEEE T-RO 25(4), 2009) take the direction of the centre on the unit sphere over the radius of the
/// ball's image there, which is the centre over R, and find it linked linearly to the camera's translation:
/// in the camera's axes (F = C) L = [ -I / R  [s]x ]. p_CB / R is of the image alone; the R in L is what is
/// believed, and a wrong one multiplies the speeds only, which moves no equilibrium: stable while R_believed
/// / R is below 2.
///
/// A robot on the floor has two velocities, so that it can serve two of the three. With F levelled the third
/// (up) never changes, whatever the robot does: it says nothing, and the other two say all. Without the
/// levelling the pitch would mix it into the forward feature. With q = (a, b, c) and l the camera's distance
/// ahead of the axle, a ball at rest moves by a' = -v + w b, b' = -w (a + l), so that
///
///     [s_1']   [ -1/R    b/R        ] [v]
///     [s_2'] = [   0    -(a + l)/R  ] [w],      det = (a + l) / R^2,
///
/// singular exactly when the ball is abeam of the axle.
class SphereFeature final : public BallFeature {
 public:
  explicit SphereFeature(double radius_m, const Eigen::Matrix3d& R_FC = Eigen::Matrix3d::Identity());

  static unsigned int selectX() { return FEATURE_LINE[0]; }
  static unsigned int selectY() { return FEATURE_LINE[1]; }
  static unsigned int selectZ() { return FEATURE_LINE[2]; }

  SphereFeature* duplicate() const override { return new SphereFeature(*this); }

 private:
  const char* name() const override { return "SphereFeature (centre over radius): "; }
  bool defined(const Eigen::Vector3d&) const override { return true; }
  Eigen::Vector3d coordinates(const Eigen::Vector3d& q, Eigen::Matrix3d& derivative) const override;

  double radius_m_;
};

}  // namespace ballservo
