// Where the ball would have been seen, had it lain there: for choosing where to look next.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "servo/avoidance/obstacle_map.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// What a turn on the spot shows for the first time.
struct UnseenFloor {
  double area_m2;
  double sooner_left;  ///< to the left it comes so many times sooner, on average, than to the right
};

/// A window of blocks around the robot, in the odometry's frame. Allocates in the constructor only.
class ViewedFloor {
 public:
  static constexpr double block_m = ObstacleMap::block_m;
  static constexpr int size = ObstacleMap::size / 2;
  static constexpr double far_m = 3.5;  ///< a ball further off may be missed

  ViewedFloor() : viewed_(FloorWindow<size>::cells, 0) {}

  /// A frame was taken from there: what lies within `half_view_rad` of straight ahead and behind nothing was
  /// seen.
  void look(const Pose2& pose, double half_view_rad, const ObstacleMap& map);

  /// The ball was lost there: what was seen before counts no longer, and floor counts less the further it is.
  void expect(const Eigen::Vector2d& p_OB) {
    std::fill(viewed_.begin(), viewed_.end(), std::uint8_t{0});
    p_OB_ = p_OB;
  }

  /// What a turn on the spot would show from there. Until the ball is seen, floor behind the first pose
  /// counts less: where a robot is set down, the ball is rather ahead.
  UnseenFloor unseen_from(const Pose2& pose, const ObstacleMap& map) const;

 private:
  template <typename Visit>
  void along(const Eigen::Vector2d& from, double heading_rad, const ObstacleMap& map,
             const Visit& visit) const;
  double likely(const Eigen::Vector2d& p_O) const;
  /// In the sector of a direction.
  double new_along_m2(const Eigen::Vector2d& from, double heading_rad, const ObstacleMap& map) const;

  FloorWindow<size> window_;
  std::vector<std::uint8_t> viewed_;
  std::optional<Pose2> start_;
  std::optional<Eigen::Vector2d> p_OB_;  // where it was lost
};

}  // namespace ballservo
