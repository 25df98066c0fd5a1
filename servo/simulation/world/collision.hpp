// What the robot's footprint touches, how far it is from everything else, and where it can get.
#pragma once

#include <limits>
#include <optional>
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

/// Where a robot that turns on the spot can be driven to. The proof is sufficient, not necessary: a disc
/// around the axle that holds the footprint in every heading, and `margin_m` around it, is moved from cell to
/// cell of a grid (flood fill; Choset and others, "Principles of Robot Motion", 2005, chapter 4); between two
/// centres it is free because it is free with half a cell to spare at both.
class PathPlanner {
 public:
  PathPlanner(const World& world, const Footprint& footprint, double margin_m, const Pose2& start);

  /// Whether a place is reached that lies `distance_m` from the ball's centre (to half a cell), from where
  /// nothing stands before a ball of that radius.
  bool reaches_view_of(const Eigen::Vector2d& p_WB, double distance_m, double ball_radius_m) const;

  /// Radius (m) of the disc that moves.
  double disc_radius_m() const { return disc_radius_m_; }

 private:
  static constexpr double cell_m_ = 0.10;
  /// Of the cell that holds a point; nothing outside the room.
  std::optional<std::size_t> cell_at(const Eigen::Vector2d& p_W) const;
  bool sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double ball_radius_m) const;

  const World& world_;
  double disc_radius_m_;
  std::size_t columns_, rows_;
  std::vector<bool> reached_;
};

}  // namespace ballservo
