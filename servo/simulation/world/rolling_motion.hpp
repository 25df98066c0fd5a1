// A ball that rolls over the floor and bounces off walls.
#pragma once

#include <Eigen/Core>

namespace ballservo {

/// Rolls straight from `start_s` on, slowed by friction, and is thrown back by the walls of a rectangle.
struct RollingMotion {
  Eigen::Vector2d velocity_mps{0, 0};  ///< at start_s
  double start_s = 0;                  ///< rests before
  double friction_mps2 = 0;            ///< deceleration along the way; it rests once it stands
  double restitution = 1;              ///< share of the speed towards a wall that a bounce gives back
  Eigen::Vector2d low_m{-1e9, -1e9}, high_m{1e9, 1e9};  ///< where its centre can be: the room less its radius

  /// Where a ball that lay at `start_m` is at a time. Exact from bounce to bounce; after 10000 bounces, or
  /// between walls that leave it no room, it rests.
  Eigen::Vector2d place(const Eigen::Vector2d& start_m, double time_s) const;
};

}  // namespace ballservo
