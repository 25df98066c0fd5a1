// What things in front of a ball hide of it, in the plane across the ray to its centre.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

/// The part of a line of constant y, from low to high.
struct ShadowSpan {
  double low = 0, high = 0;
};

/// The ball as seen from a camera: a circle of radius `tangent` about the origin of the plane z = 1 of a
/// frame whose z axis points to its centre.
struct BallDisc {
  Eigen::Vector3d origin_W{0, 0, 0};                   ///< the camera
  Eigen::Matrix3d R_WD = Eigen::Matrix3d::Identity();  ///< columns: the plane's axes, and the ray
  double tangent = 0;                                  ///< of half the angle that the ball spans
  double distance_m = 0;
  double near_m = 0, far_m = 0;  ///< along the ray: what hides the ball lies between the two

  /// Nothing where the camera is inside the ball. The axes are those of `R_WC` turned as little as need be.
  static std::optional<BallDisc> of(const SceneBall& ball, const Eigen::Isometry3d& X_WC);
};

/// The shadow of one thing: convex.
class Shadow {
 public:
  /// Nothing where it hides nothing of the disc.
  static std::optional<Shadow> of(const SceneSolid& solid, const BallDisc& disc);
  static std::optional<Shadow> of(const SceneBall& ball, const BallDisc& disc);

  std::optional<ShadowSpan> at(double y) const;

 private:
  std::vector<Eigen::Vector2d> polygon_;  // counter-clockwise; else a conic
  Eigen::Vector3d cone_axis_{0, 0, 1};    // the other ball's centre
  double cone_square_ = 0;                // |centre|^2 - radius^2
};

}  // namespace ballservo
