#include "servo/simulation/world/collision.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ballservo {

namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double segment_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

/// Whether some edge of `a` (counter-clockwise, convex) has all of `b` on its outer side.
bool separated_by_edge(const Polygon& a, const Polygon& b) {
  for (std::size_t k = 0; k < a.size(); ++k) {
    const Eigen::Vector2d edge = a[(k + 1) % a.size()] - a[k];
    const Eigen::Vector2d outward(edge.y(), -edge.x());
    if (std::all_of(b.begin(), b.end(),
                    [&](const Eigen::Vector2d& p) { return (p - a[k]).dot(outward) > 0; })) {
      return true;
    }
  }
  return false;
}

/// Distance between convex polygons; 0 where they touch or overlap (separating axes, then vertices against
/// edges).
double polygon_distance(const Polygon& a, const Polygon& b) {
  if (!separated_by_edge(a, b) && !separated_by_edge(b, a)) return 0.0;
  double distance = std::numeric_limits<double>::infinity();
  const auto vertices_to_edges = [&](const Polygon& points, const Polygon& edges) {
    for (const Eigen::Vector2d& p : points) {
      for (std::size_t k = 0; k < edges.size(); ++k) {
        distance = std::min(distance, segment_distance(p, edges[k], edges[(k + 1) % edges.size()]));
      }
    }
  };
  vertices_to_edges(a, b);
  vertices_to_edges(b, a);
  return distance;
}

}  // namespace

double footprint_distance(const Footprint& footprint, const Eigen::Vector2d& p_R) {
  const double dx = std::max({p_R.x() - footprint.front_m, -footprint.rear_m - p_R.x(), 0.0});
  const double dy = std::max(std::abs(p_R.y()) - footprint.half_width_m, 0.0);
  return std::hypot(dx, dy);
}

ContactReport find_contacts(const World& world, const Footprint& footprint, const Pose2& pose,
                            double time_s) {
  const std::array<Eigen::Vector2d, 4> corners_R{{{footprint.front_m, -footprint.half_width_m},
                                                  {footprint.front_m, footprint.half_width_m},
                                                  {-footprint.rear_m, footprint.half_width_m},
                                                  {-footprint.rear_m, -footprint.half_width_m}}};
  Polygon robot;
  for (const Eigen::Vector2d& corner : corners_R) robot.push_back(in_world_frame(pose, corner));

  ContactReport report;
  const auto consider = [&report](double clearance, const std::string& name) {
    if (clearance < report.clearance_m) {
      report.clearance_m = std::max(clearance, 0.0);
      report.nearest = name;
    }
  };
  const Room& room = world.room;
  for (const Eigen::Vector2d& p : robot) {
    consider(
        std::min({p.x() - room.x_min_m, room.x_max_m - p.x(), p.y() - room.y_min_m, room.y_max_m - p.y()}),
        "wall");
  }
  for (const Obstacle& obstacle : world.obstacles) {
    if (obstacle.bottom_m() >= robot_height_m) continue;
    const FloorOutline outline = floor_outline(obstacle);
    const double clearance =
        outline.radius_m > 0
            ? footprint_distance(footprint, in_robot_frame(pose, outline.points_m.front())) - outline.radius_m
            : polygon_distance(robot, outline.points_m);
    consider(clearance, obstacle.name);
  }
  for (const Ball& ball : world.balls) {
    const Eigen::Vector3d p_WB = ball.p_WB(time_s);
    if (p_WB.z() - ball.radius_m() >= robot_height_m) continue;
    const double clearance =
        footprint_distance(footprint, in_robot_frame(pose, p_WB.head<2>())) - ball.radius_m();
    if (clearance < report.ball_clearance_m) {
      report.ball_clearance_m = std::max(clearance, 0.0);
      report.nearest_ball = ball.name;
    }
  }
  return report;
}

}  // namespace ballservo
