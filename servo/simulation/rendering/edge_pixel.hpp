// The colour of a pixel that edges cross: 16 rays for what stands and lies in the room, and the exact share
// of the balls.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

/// A ball as the camera sees it: its tangent cone.
struct BallCone {
  Eigen::Vector3d axis{0, 0, 1};  // world
  double cos_alpha = 1, sin_alpha = 0;
  double tangent_distance = 0;  // from the camera to the outline's points on the ball
  int ball = 0;

  /// The sine of the angle by which a unit ray lies inside: accurate for small balls too.
  double inside(double cosine, double sine) const { return sin_alpha * cosine - cos_alpha * sine; }
};

/// One frame's view of the scene.
struct Viewpoint {
  const Scene& scene;
  Eigen::Vector3d origin;
  Eigen::Matrix3d R_WC;
  std::vector<BallCone> cones;  // nearest first

  Viewpoint(const Scene& scene, const Eigen::Isometry3d& X_WC);
};

/// The corner rays of a pixel in world axes, interpolated in between. Between neighbouring corners a lens is
/// straight to a few 1e-4 px, and the corners themselves are exact.
struct PixelRays {
  Eigen::Vector3d base, along_x, along_y, twist;

  PixelRays(const Eigen::Vector3d& r00, const Eigen::Vector3d& r10, const Eigen::Vector3d& r01,
            const Eigen::Vector3d& r11)
      : base(r00), along_x(r10 - r00), along_y(r01 - r00), twist(r11 - r10 - r01 + r00) {}
  /// x and y from 0 to 1 over the pixel; not of unit length.
  Eigen::Vector3d at(double x, double y) const { return base + x * along_x + y * along_y + (x * y) * twist; }
  Eigen::Vector3d slope_x(double y) const { return along_x + y * twist; }
  Eigen::Vector3d slope_y(double x) const { return along_y + x * twist; }
};

/// How the renderer counts a ball's outline: the share (0 to 1) of a square that lies on the inner side of a
/// straight line. `inside` is the signed distance of the square's centre from the line, positive inside;
/// (slope_x, slope_y) the line's unit normal, either way round; lengths in the unit of `side`.
double half_plane_share(double inside, double slope_x, double slope_y, double side);

/// A ball whose cone reaches into a pixel, and whether the pixel lies all inside it.
struct NearBall {
  const BallCone* cone;
  bool whole;
};

/// `solids` are those that the pixel's rays could meet; a ball's outline runs through the pixel where it
/// comes within `reach_rad` of its centre. `pixel_rad`: the angle that a pixel spans. `near_balls` is room to
/// work.
Rgb edge_pixel(const Viewpoint& view, const PixelRays& rays, const std::vector<int>& solids, double reach_rad,
               double pixel_rad, std::vector<NearBall>& near_balls);

}  // namespace ballservo
