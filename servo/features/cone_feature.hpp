// The ball's tangent cone as a visual feature.
#pragma once

#include "servo/features/ball_feature.hpp"

namespace ballservo {

/// Log range and direction of the ball's centre: s = (log rho, azimuth, elevation), rho = |p_CB| in metres,
/// azimuth positive to the left and elevation positive upwards of F's first axis (rad).
///
/// All three are functions of the cone that touches the ball, so of the image: the direction is that of its
/// axis, and rho = R / sin(alpha) for its half angle alpha and the ball's radius R, so that in the error
/// log(rho / rho*) = log(sin alpha* / sin alpha) the radius cancels. Range and direction are coupled neither
/// to each other nor, the range, to the camera's rotation, as with the spherical projection of Fomena and
/// Chaumette
/// ("Improvements on visual servoing from spherical targets using a spherical projection model", IEEE T-RO
/// 25(4), 2009).
///
/// With q = R_FC p_CB = (a, b, c) and r^2 = a^2 + b^2,
///
///             [ a / rho^2         b / rho^2         c / rho^2 ]
///     ds/dq = [ -b / r^2          a / r^2           0         ]
///             [ -a c / (r rho^2)  -b c / (r rho^2)  r / rho^2 ],
///
/// not defined for a centre straight above or below the camera in F (r = 0).
///
/// On a robot on the floor, with F levelled, elevation and log range are tied by the ball's height, so that
/// the first two serve. There, with l the camera's distance ahead of the axle, a' = -v + w b and b' = -w (a +
/// l), so that
///
///     [rho'/rho ]   [ -a / rho^2   -l b / rho^2      ] [v]
///     [azimuth' ] = [  b / r^2     -(1 + l a / r^2)  ] [w],      det = (a + l) / rho^2,
///
/// singular exactly when the ball is abeam of the axle (a + l = 0).
class ConeFeature final : public BallFeature {
 public:
  explicit ConeFeature(const Eigen::Matrix3d& R_FC = ahead_left_up());

  static unsigned int selectLogRange() { return FEATURE_LINE[0]; }
  static unsigned int selectAzimuth() { return FEATURE_LINE[1]; }
  static unsigned int selectElevation() { return FEATURE_LINE[2]; }

  ConeFeature* duplicate() const override { return new ConeFeature(*this); }

 private:
  const char* name() const override { return "ConeFeature (log range, azimuth, elevation): "; }
  bool defined(const Eigen::Vector3d& q) const override;
  Eigen::Vector3d coordinates(const Eigen::Vector3d& q, Eigen::Matrix3d& derivative) const override;
};

}  // namespace ballservo
