// Proves that a robot can get somewhere: a way for it through a world that is known.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// Distance (m) in the floor plane from a point to the nearest wall, or obstacle that the robot cannot pass
/// under; 0 or less inside.
double floor_clearance_m(const World& world, const Eigen::Vector2d& p_W);

/// Where a robot that turns on the spot can be driven to. The proof is sufficient, not necessary: a disc
/// around the axle that holds the footprint in every heading, and `margin_m` around it, is moved from cell to
/// cell of a grid (flood fill; Choset and others, "Principles of Robot Motion", 2005, chapter 4); between two
/// centres it is free because it is free with half a cell to spare at both.
class PathPlanner {
 public:
  PathPlanner(const World& world, const Footprint& footprint, double margin_m, const Pose2& start);

  /// Whether the disc can be brought from the start to within half a cell of that point.
  bool reaches(const Eigen::Vector2d& p_W) const;

  /// Whether a place is reached that lies `distance_m` from the ball's centre (to half a cell), from where
  /// nothing stands before a ball of that radius.
  bool reaches_view_of(const Eigen::Vector2d& p_WB, double distance_m, double ball_radius_m) const;

  /// Radius (m) of the disc that moves.
  double disc_radius_m() const { return disc_radius_m_; }

 private:
  static constexpr double cell_m_ = 0.10;
  bool sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double ball_radius_m) const;
  bool reached(int column, int row) const;

  const World& world_;
  double disc_radius_m_;
  int columns_, rows_;
  std::vector<std::uint8_t> reached_;
};

}  // namespace ballservo
