// What the robot's footprint touches, how far it is from everything else, and where it can get.
#pragma once

#include <limits>
#include <string>
#include <vector>

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

/// Where a robot that turns on the spot cannot be driven to. "No" is a proof: the boxes of a grid over place
/// and heading are searched, and a box is closed only where the footprint, smaller all around by as much as
/// any of its points moves within the box, hits something in the middle of it: then the true one does
/// everywhere in the box. Where all that are open do not lead there, nothing does (Choset and others,
/// "Principles of Robot Motion", 2005, chapter 6, approximate cell decomposition). "Yes" may err by 8 cm of a
/// gap's width.
class PathPlanner {
 public:
  PathPlanner(const World& world, const Footprint& footprint, const Pose2& start);

  /// Whether a place may be reached that lies `distance_m` from the ball's centre, in the floor plane, facing
  /// it with some of the ball in sight from `eye_m` over the floor.
  bool may_reach_view_of(const Eigen::Vector3d& p_WB, double ball_radius_m, double distance_m, double eye_m);

 private:
  static constexpr double cell_m_ = 0.04;
  static constexpr int headings_ = 72;
  Eigen::Vector2d center_m(std::size_t cell) const;
  bool is_open(std::size_t cell, int heading);
  bool sees(const Eigen::Vector2d& from, const Eigen::Vector3d& p_WB, double ball_radius_m,
            double eye_m) const;

  const World& world_;
  Footprint footprint_, inner_;
  Pose2 start_;
  int columns_, rows_;
  std::vector<float> clearance_m_;  // of the middle of each cell; below 0: not asked yet
};

}  // namespace ballservo
