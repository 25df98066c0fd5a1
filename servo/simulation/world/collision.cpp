#include "servo/simulation/world/collision.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ballservo {

namespace {

/// Whether some edge of `a` has all of `b` on its outer side.
bool separated_by_edge(const FloorOutline& a, const FloorOutline& b) {
  for (std::size_t k = 0; k < a.points_m.size(); ++k) {
    const Eigen::Vector2d edge = a.points_m[(k + 1) % a.points_m.size()] - a.points_m[k];
    const Eigen::Vector2d outward(edge.y(), -edge.x());
    if (std::all_of(b.points_m.begin(), b.points_m.end(),
                    [&](const Eigen::Vector2d& p) { return (p - a.points_m[k]).dot(outward) > 0; })) {
      return true;
    }
  }
  return false;
}

/// Distance between outlines with corners; 0 where they touch or overlap (separating axes, then corners
/// against edges).
double outline_distance_m(const FloorOutline& a, const FloorOutline& b) {
  if (!separated_by_edge(a, b) && !separated_by_edge(b, a)) return 0.0;
  double distance = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector2d& p : a.points_m) distance = std::min(distance, b.distance_m(p));
  for (const Eigen::Vector2d& p : b.points_m) distance = std::min(distance, a.distance_m(p));
  return distance;
}

double to_wall_m(const Room& room, const Eigen::Vector2d& p) {
  return std::min({p.x() - room.x_min_m, room.x_max_m - p.x(), p.y() - room.y_min_m, room.y_max_m - p.y()});
}

/// Distance in the floor plane from a point to the nearest wall, or obstacle that the robot cannot pass
/// under; 0 or less inside.
double floor_clearance_m(const World& world, const Eigen::Vector2d& p) {
  double clearance_m = to_wall_m(world.room, p);
  for (const Obstacle& obstacle : world.obstacles) {
    if (obstacle.bottom_m() >= robot_height_m) continue;
    const double away_m = (p - obstacle.center_m.head<2>()).norm() - obstacle.bounding_radius_m();
    if (away_m < clearance_m) clearance_m = std::min(clearance_m, floor_outline(obstacle).distance_m(p));
  }
  return clearance_m;
}

}  // namespace

ContactReport find_contacts(const World& world, const Footprint& footprint, const Pose2& pose,
                            double time_s) {
  FloorOutline robot;
  for (const auto& [x_m, side] : {std::pair(footprint.front_m, -1), std::pair(footprint.front_m, 1),
                                  std::pair(-footprint.rear_m, 1), std::pair(-footprint.rear_m, -1)}) {
    robot.points_m.push_back(in_world_frame(pose, {x_m, side * footprint.half_width_m}));
  }

  ContactReport report;
  const auto consider = [&report](double clearance, const std::string& name) {
    if (clearance < report.clearance_m) {
      report.clearance_m = std::max(clearance, 0.0);
      report.nearest = name;
    }
  };
  for (const Eigen::Vector2d& p : robot.points_m) consider(to_wall_m(world.room, p), "wall");
  for (const Obstacle& obstacle : world.obstacles) {
    if (obstacle.bottom_m() >= robot_height_m) continue;
    const FloorOutline outline = floor_outline(obstacle);
    const double clearance =
        outline.radius_m > 0
            ? footprint.distance_m(in_robot_frame(pose, outline.points_m.front())) - outline.radius_m
            : outline_distance_m(robot, outline);
    consider(clearance, obstacle.name);
  }
  for (const Ball& ball : world.balls) {
    const Eigen::Vector3d p_WB = ball.p_WB(time_s);
    if (p_WB.z() - ball.radius_m() >= robot_height_m) continue;
    const double clearance = footprint.distance_m(in_robot_frame(pose, p_WB.head<2>())) - ball.radius_m();
    if (clearance < report.ball_clearance_m) {
      report.ball_clearance_m = std::max(clearance, 0.0);
      report.nearest_ball = ball.name;
    }
  }
  return report;
}

PathPlanner::PathPlanner(const World& world, const Footprint& footprint, double margin_m, const Pose2& start)
    : world_(world), disc_radius_m_(footprint.reach_m() + margin_m) {
  const Room& room = world.room;
  columns_ = static_cast<std::size_t>(std::ceil((room.x_max_m - room.x_min_m) / cell_m_));
  rows_ = static_cast<std::size_t>(std::ceil((room.y_max_m - room.y_min_m) / cell_m_));
  reached_.assign(columns_ * rows_, false);
  std::vector<Eigen::Vector2d> open{{start.x_m, start.y_m}};
  while (!open.empty()) {
    const auto cell = cell_at(open.back());
    open.pop_back();
    if (!cell || reached_[*cell]) continue;
    const Eigen::Vector2d center(room.x_min_m + (static_cast<double>(*cell % columns_) + 0.5) * cell_m_,
                                 room.y_min_m + (static_cast<double>(*cell / columns_) + 0.5) * cell_m_);
    if (floor_clearance_m(world_, center) < disc_radius_m_ + 0.5 * cell_m_) continue;
    reached_[*cell] = true;
    for (const auto& [x, y] : {std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1), std::pair(0, 1)})
      open.emplace_back(center.x() + x * cell_m_, center.y() + y * cell_m_);
  }
}

std::optional<std::size_t> PathPlanner::cell_at(const Eigen::Vector2d& p_W) const {
  const double column = std::floor((p_W.x() - world_.room.x_min_m) / cell_m_);
  const double row = std::floor((p_W.y() - world_.room.y_min_m) / cell_m_);
  if (!(column >= 0 && row >= 0)) return std::nullopt;
  const auto c = static_cast<std::size_t>(column), r = static_cast<std::size_t>(row);
  return c < columns_ && r < rows_ ? std::make_optional(r * columns_ + c) : std::nullopt;
}

bool PathPlanner::sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double ball_radius_m) const {
  const int steps = std::max(1, static_cast<int>(std::ceil((to - from).norm() / 0.02)));
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector2d p = from + (to - from) * (static_cast<double>(k) / steps);
    for (const Obstacle& obstacle : world_.obstacles) {
      if (obstacle.bottom_m() < robot_height_m && floor_outline(obstacle).distance_m(p) < ball_radius_m)
        return false;
    }
  }
  return true;
}

bool PathPlanner::reaches_view_of(const Eigen::Vector2d& p_WB, double distance_m,
                                  double ball_radius_m) const {
  const int directions = std::max(16, static_cast<int>(std::ceil(2 * M_PI * distance_m / cell_m_)));
  for (int k = 0; k < directions; ++k) {
    const double angle = 2 * M_PI * k / directions;
    const Eigen::Vector2d place = p_WB + distance_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    const auto cell = cell_at(place);
    if (cell && reached_[*cell] && sees(place, p_WB, ball_radius_m)) return true;
  }
  return false;
}

}  // namespace ballservo
