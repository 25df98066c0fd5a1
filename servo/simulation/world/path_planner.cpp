#include "servo/simulation/world/path_planner.hpp"

#include <algorithm>
#include <cmath>

#include "servo/simulation/world/collision.hpp"

namespace ballservo {

namespace {

/// Distance from a point to an outline seen from above; 0 inside.
double outline_distance_m(const FloorOutline& outline, const Eigen::Vector2d& p) {
  if (outline.radius_m > 0) return std::max(0.0, (p - outline.points_m.front()).norm() - outline.radius_m);
  bool inside = true;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < outline.points_m.size(); ++k) {
    const Eigen::Vector2d a = outline.points_m[k], b = outline.points_m[(k + 1) % outline.points_m.size()];
    const Eigen::Vector2d along = b - a, away = p - a;
    if (along.x() * away.y() - along.y() * away.x() < 0) inside = false;
    const double share = std::clamp(away.dot(along) / along.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (away - share * along).norm());
  }
  return inside ? 0.0 : nearest;
}

double holding_radius_m(const Footprint& body) {
  return std::hypot(std::max(body.front_m, body.rear_m), body.half_width_m);
}

}  // namespace

double floor_clearance_m(const World& world, const Eigen::Vector2d& p) {
  const Room& room = world.room;
  double clearance =
      std::min({p.x() - room.x_min_m, room.x_max_m - p.x(), p.y() - room.y_min_m, room.y_max_m - p.y()});
  for (const Obstacle& obstacle : world.obstacles) {
    if (obstacle.bottom_m() >= robot_height_m) continue;
    const double away_m = (p - obstacle.center_m.head<2>()).norm() - obstacle.bounding_radius_m();
    if (away_m < clearance) clearance = std::min(clearance, outline_distance_m(floor_outline(obstacle), p));
  }
  return clearance;
}

PathPlanner::PathPlanner(const World& world, const Footprint& footprint, double margin_m, const Pose2& start)
    : world_(world), disc_radius_m_(holding_radius_m(footprint) + margin_m) {
  const Room& room = world.room;
  columns_ = static_cast<int>(std::ceil((room.x_max_m - room.x_min_m) / cell_m_));
  rows_ = static_cast<int>(std::ceil((room.y_max_m - room.y_min_m) / cell_m_));
  reached_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0);

  enum : std::uint8_t { unknown, yes, no };
  std::vector<std::pair<int, int>> open;
  const auto visit = [&](int column, int row) {
    if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
    std::uint8_t& cell = reached_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                  static_cast<std::size_t>(column)];
    if (cell != unknown) return;
    const Eigen::Vector2d center(room.x_min_m + (column + 0.5) * cell_m_,
                                 room.y_min_m + (row + 0.5) * cell_m_);
    cell = floor_clearance_m(world_, center) >= disc_radius_m_ + 0.5 * cell_m_ ? yes : no;
    if (cell == yes) open.emplace_back(column, row);
  };
  const int first_column = static_cast<int>(std::floor((start.x_m - room.x_min_m) / cell_m_));
  const int first_row = static_cast<int>(std::floor((start.y_m - room.y_min_m) / cell_m_));
  visit(first_column, first_row);
  while (!open.empty()) {
    const auto [column, row] = open.back();
    open.pop_back();
    visit(column - 1, row);
    visit(column + 1, row);
    visit(column, row - 1);
    visit(column, row + 1);
  }
}

bool PathPlanner::reached(int column, int row) const {
  return column >= 0 && row >= 0 && column < columns_ && row < rows_ &&
         reached_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(column)] == 1;
}

bool PathPlanner::reaches(const Eigen::Vector2d& p_W) const {
  return reached(static_cast<int>(std::floor((p_W.x() - world_.room.x_min_m) / cell_m_)),
                 static_cast<int>(std::floor((p_W.y() - world_.room.y_min_m) / cell_m_)));
}

bool PathPlanner::sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double ball_radius_m) const {
  const double distance = (to - from).norm();
  const int steps = std::max(1, static_cast<int>(std::ceil(distance / 0.02)));
  for (int k = 0; k < steps; ++k) {
    const Eigen::Vector2d p = from + (to - from) * (static_cast<double>(k) / steps);
    for (const Obstacle& obstacle : world_.obstacles) {
      if (obstacle.bottom_m() >= robot_height_m) continue;
      if (outline_distance_m(floor_outline(obstacle), p) < ball_radius_m) return false;
    }
  }
  return true;
}

bool PathPlanner::reaches_view_of(const Eigen::Vector2d& p_WB, double distance_m,
                                  double ball_radius_m) const {
  const int directions = std::max(16, static_cast<int>(std::ceil(6.283185307179586 * distance_m / cell_m_)));
  for (int k = 0; k < directions; ++k) {
    const double angle = 6.283185307179586 * k / directions;
    const Eigen::Vector2d place = p_WB + distance_m * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (reaches(place) && sees(place, p_WB, ball_radius_m)) return true;
  }
  return false;
}

}  // namespace ballservo
