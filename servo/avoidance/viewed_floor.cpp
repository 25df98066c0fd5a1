#include "servo/avoidance/viewed_floor.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {
constexpr int directions = 36;  // of a turn on the spot
constexpr double apart_rad = 6.283185307179586 / directions;
// So likely is the ball behind the start, or far from where it was lost.
constexpr double least_weight = 0.05;
constexpr double lost_m = 1.0;  // half as likely so far from where it was lost
constexpr double view_step_m = ViewedFloor::block_m;
}  // namespace

/// The blocks of the window along a line of sight, until something stands in it.
template <typename Visit>
void ViewedFloor::along(const Eigen::Vector2d& from, double heading_rad, const ObstacleMap& map,
                        const Visit& visit) const {
  const Eigen::Vector2d ahead(std::cos(heading_rad), std::sin(heading_rad));
  for (double range_m = 0.5 * view_step_m; range_m < far_m; range_m += view_step_m) {
    const Eigen::Vector2d p = from + range_m * ahead;
    const FloorCell block{floor_index(p.x(), block_m), floor_index(p.y(), block_m)};
    if (!window_.contains(block) || map.is_block_occupied(block.column, block.row)) return;
    visit(block, range_m);
  }
}

void ViewedFloor::look(const Pose2& pose, double half_view_rad, const ObstacleMap& map) {
  window_.follow({floor_index(pose.x_m, block_m), floor_index(pose.y_m, block_m)},
                 [this](std::size_t index) { viewed_[index] = 0; });
  if (!start_) start_ = pose;
  const double apart_rad = view_step_m / far_m;
  const int rays = static_cast<int>(half_view_rad / apart_rad);
  for (int k = -rays; k <= rays; ++k) {
    along({pose.x_m, pose.y_m}, pose.yaw_rad + k * apart_rad, map,
          [this](const FloorCell& block, double) { viewed_[window_.index(block)] = 1; });
  }
}

/// From 1, ahead of the start or where the ball was lost, to `least_weight`.
double ViewedFloor::likely(const Eigen::Vector2d& p_O) const {
  if (p_OB_)
    return least_weight + (1.0 - least_weight) / (1.0 + (p_O - *p_OB_).squaredNorm() / (lost_m * lost_m));
  if (!start_) return 1.0;
  const Eigen::Vector2d p_R = in_robot_frame(*start_, p_O);
  const double ahead = 0.5 + 0.5 * p_R.x() / std::max(p_R.norm(), 1e-6);
  return least_weight + (1.0 - least_weight) * ahead * ahead;
}

double ViewedFloor::new_along_m2(const Eigen::Vector2d& from, double heading_rad,
                                 const ObstacleMap& map) const {
  double sum_m2 = 0;
  along(from, heading_rad, map, [&](const FloorCell& block, double range_m) {
    if (viewed_[window_.index(block)] != 0) return;
    sum_m2 += range_m * apart_rad * view_step_m *
              likely({(block.column + 0.5) * block_m, (block.row + 0.5) * block_m});
  });
  return sum_m2;
}

UnseenFloor ViewedFloor::unseen_from(const Pose2& pose, const ObstacleMap& map) const {
  double left_m2rad = 0, sum_m2 = 0;
  for (int k = 0; k < directions; ++k) {
    const double turn_rad = (k + 0.5) * apart_rad;
    const double new_m2 = new_along_m2({pose.x_m, pose.y_m}, pose.yaw_rad + turn_rad, map);
    left_m2rad += new_m2 * turn_rad;
    sum_m2 += new_m2;
  }
  return {sum_m2, sum_m2 > 0.0 ? directions * apart_rad * sum_m2 / left_m2rad - 1.0 : 1.0};
}

}  // namespace ballservo
