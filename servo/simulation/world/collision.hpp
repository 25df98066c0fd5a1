// What the robot's footprint touches, and how far it is from everything else.
#pragma once

#include <limits>
#include <string>

#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// Things that hang higher than this (m) are driven under.
inline constexpr double robot_height_m = 0.40;

struct ContactReport {
  double clearance_m =
      std::numeric_limits<double>::infinity();  ///< footprint to the nearest wall or obstacle; 0: touching
  std::string nearest;                          ///< its name; "wall" for walls
  double ball_clearance_m = std::numeric_limits<double>::infinity();  ///< to the nearest ball
  std::string nearest_ball;

  bool collision() const { return clearance_m <= 0; }
  bool ball_contact() const { return ball_clearance_m <= 0; }
};

/// Exact distances in the floor plane between the rectangle and every outline (rectangles, circles, walls).
ContactReport find_contacts(const World& world, const Footprint& footprint, const Pose2& pose, double time_s);

/// Distance (m) from a point of the robot's frame to the footprint; 0 inside.
double footprint_distance(const Footprint& footprint, const Eigen::Vector2d& p_R);

}  // namespace ballservo
