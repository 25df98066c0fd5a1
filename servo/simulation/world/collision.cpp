#include "servo/simulation/world/collision.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

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
  for (const Eigen::Vector2d& corner : footprint.corners())
    robot.points_m.push_back(in_world_frame(pose, corner));

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

PathPlanner::PathPlanner(const World& world, const Footprint& footprint, const Pose2& start)
    : world_(world), footprint_(footprint), start_(start) {
  const double moves_m = std::hypot(0.5, 0.5) * cell_m_ + footprint.reach_m() * M_PI / headings_;
  inner_ = {footprint.front_m - moves_m, footprint.rear_m - moves_m, footprint.half_width_m - moves_m};
  const Room& room = world.room;
  columns_ = static_cast<int>(std::ceil((room.x_max_m - room.x_min_m) / cell_m_));
  rows_ = static_cast<int>(std::ceil((room.y_max_m - room.y_min_m) / cell_m_));
  clearance_m_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -1.0F);
}

Eigen::Vector2d PathPlanner::center_m(std::size_t cell) const {
  const auto columns = static_cast<std::size_t>(columns_);
  return {world_.room.x_min_m + (static_cast<double>(cell % columns) + 0.5) * cell_m_,
          world_.room.y_min_m + (static_cast<double>(cell / columns) + 0.5) * cell_m_};
}

bool PathPlanner::is_open(std::size_t cell, int heading) {
  const Eigen::Vector2d p = center_m(cell);
  float& clearance_m = clearance_m_[cell];
  if (clearance_m < 0) clearance_m = static_cast<float>(std::max(0.0, floor_clearance_m(world_, p)));
  if (clearance_m > footprint_.reach_m()) return true;
  if (clearance_m < std::min({inner_.front_m, inner_.rear_m, inner_.half_width_m})) return false;
  return !find_contacts(world_, inner_, {p.x(), p.y(), 2 * M_PI * heading / headings_}, 0).collision();
}

bool PathPlanner::may_reach_view_of(const Eigen::Vector3d& p_WB, double ball_radius_m, double distance_m,
                                    double eye_m) {
  struct Box {
    double to_go_m;
    std::size_t cell;
    int heading;
    bool operator<(const Box& other) const { return to_go_m > other.to_go_m; }
  };
  std::priority_queue<Box> open;  // the nearest to the goal first
  std::vector<bool> known(clearance_m_.size() * headings_, false);
  const auto put = [&](int column, int row, int heading) {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
    const auto cell =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    heading = (heading + headings_) % headings_;
    const std::size_t box = cell * headings_ + static_cast<std::size_t>(heading);
    if (known[box]) return;
    known[box] = true;
    if (is_open(cell, heading))
      open.push({std::abs((center_m(cell) - p_WB.head<2>()).norm() - distance_m), cell, heading});
  };
  put(static_cast<int>(std::floor((start_.x_m - world_.room.x_min_m) / cell_m_)),
      static_cast<int>(std::floor((start_.y_m - world_.room.y_min_m) / cell_m_)),
      static_cast<int>(std::lround(wrap_angle(start_.yaw_rad) * headings_ / (2 * M_PI))));
  while (!open.empty()) {
    const Box box = open.top();
    open.pop();
    const Eigen::Vector2d p = center_m(box.cell), to_ball = p_WB.head<2>() - p;
    const double aside =
        wrap_angle(std::atan2(to_ball.y(), to_ball.x()) - 2 * M_PI * box.heading / headings_);
    if (box.to_go_m <= cell_m_ && std::abs(aside) <= M_PI / headings_ + cell_m_ / distance_m &&
        sees(p, p_WB, ball_radius_m, eye_m))
      return true;
    const int column = static_cast<int>(box.cell) % columns_, row = static_cast<int>(box.cell) / columns_;
    for (const int by : {-1, 1}) {
      put(column + by, row, box.heading);
      put(column, row + by, box.heading);
      put(column, row, box.heading + by);
    }
  }
  return false;
}

/// Whether the sight to some point across the ball, or over it, is free.
bool PathPlanner::sees(const Eigen::Vector2d& from, const Eigen::Vector3d& p_WB, double ball_radius_m,
                       double eye_m) const {
  const Eigen::Vector3d eye(from.x(), from.y(), eye_m);
  const Eigen::Vector3d across = (p_WB - eye).cross(Eigen::Vector3d::UnitZ()).normalized() * ball_radius_m;
  const Eigen::Vector3d over(0, 0, ball_radius_m);
  const auto hidden = [&](const Eigen::Vector3d& to) {
    const int steps = std::max(1, static_cast<int>(std::ceil((to - eye).norm() / 0.02)));
    return std::any_of(world_.obstacles.begin(), world_.obstacles.end(), [&](const Obstacle& obstacle) {
      const FloorOutline outline = floor_outline(obstacle);
      for (int k = 0; k < steps; ++k) {
        const Eigen::Vector3d p = eye + (to - eye) * (static_cast<double>(k) / steps);
        if (p.z() > obstacle.bottom_m() && p.z() < obstacle.top_m() && outline.distance_m(p.head<2>()) <= 0)
          return true;
      }
      return false;
    });
  };
  for (const double side : {0.0, -0.9, 0.9}) {
    if (!hidden(p_WB + side * across) || !hidden(p_WB + side * over)) return true;
  }
  return false;
}

}  // namespace ballservo
