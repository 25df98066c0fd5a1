#include "app/scenario/scenario_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo {

namespace {

constexpr double time_step_s = 0.1;  // between the moments at which a moving ball is looked at

/// Distance (m) from a point to an obstacle's surface; 0 inside.
double distance_to(const Obstacle& obstacle, const Eigen::Vector3d& p) {
  const double c = std::cos(obstacle.yaw_rad), s = std::sin(obstacle.yaw_rad);
  const Eigen::Vector3d away = p - obstacle.center_m;
  const Eigen::Vector3d q(c * away.x() + s * away.y(), -s * away.x() + c * away.y(), away.z());
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape)) {
    return (q.cwiseAbs() - box->size_m / 2).cwiseMax(0.0).norm();
  }
  if (const auto* cylinder = std::get_if<CylinderShape>(&obstacle.shape)) {
    return std::hypot(std::max(std::hypot(q.x(), q.y()) - cylinder->radius_m, 0.0),
                      std::max(std::abs(q.z()) - cylinder->height_m / 2, 0.0));
  }
  const double radius = std::get<DiscShape>(obstacle.shape).radius_m;
  return std::hypot(q.x(), std::max(std::hypot(q.y(), q.z()) - radius, 0.0));
}

bool inside_room(const Room& room, const Eigen::Vector3d& p, double margin_m) {
  constexpr double touching_m = 1e-9;  // a ball may lie on the floor
  return p.x() - margin_m >= room.x_min_m && p.x() + margin_m <= room.x_max_m &&
         p.y() - margin_m >= room.y_min_m && p.y() + margin_m <= room.y_max_m &&
         p.z() - margin_m >= -touching_m && p.z() + margin_m <= room.height_m;
}

std::string position_text(const Eigen::Vector3d& p) {
  return fmt::format("({:.3g}, {:.3g}, {:.3g}) m", p.x(), p.y(), p.z());
}

void check_ball(YamlNode node, std::size_t index, const Scenario& scenario, const WorldOptions& reading,
                const ScenarioReading& parts) {
  const World& world = reading.world;
  const Ball& ball = world.balls[index];
  const double radius = ball.radius_m();
  if (parts.robot_ok) {
    World alone;
    alone.balls = {ball};
    if (find_contacts(alone, scenario.robot.footprint, scenario.robot.pose, 0).ball_contact()) {
      node.fault("position", "inside or touching the robot at its start",
                 "a place outside the robot's footprint");
      return;
    }
  }
  const bool moves = !std::holds_alternative<StaticMotion>(ball.motion);
  const int moments = moves ? static_cast<int>(scenario.duration_s / time_step_s) : 0;
  for (int k = 0; k <= moments; ++k) {
    const double time_s = k * time_step_s;
    const Eigen::Vector3d p_WB = ball.p_WB(time_s);
    const std::string when = moves ? fmt::format(" at {:.1f} s", time_s) : "";
    if (reading.room_ok && !inside_room(world.room, p_WB, radius)) {
      node.fault("position", position_text(p_WB) + when + ": outside the room, or in a wall or the floor",
                 "a place inside the room, a radius from walls and floor");
      return;
    }
    for (std::size_t j = 0; j < world.obstacles.size(); ++j) {
      if (reading.obstacle_ok[j] && distance_to(world.obstacles[j], p_WB) < radius) {
        node.fault("position", position_text(p_WB) + when + ": in obstacle " + world.obstacles[j].name,
                   "a place outside every obstacle");
        return;
      }
    }
    for (std::size_t j = 0; j < index; ++j) {
      if (reading.ball_ok[j] &&
          (world.balls[j].p_WB(time_s) - p_WB).norm() < radius + world.balls[j].radius_m()) {
        node.fault("position", position_text(p_WB) + when + ": in ball " + world.balls[j].name,
                   "a place outside every other ball");
        return;
      }
    }
  }
}

void check_obstacle(YamlNode node, const Obstacle& obstacle, const Scenario& scenario,
                    const WorldOptions& reading, const ScenarioReading& parts) {
  if (reading.room_ok && !inside_room(reading.world.room, obstacle.center_m, 0)) {
    node.fault("position", position_text(obstacle.center_m) + ": outside the room",
               "a place inside the room");
    return;
  }
  if (!parts.robot_ok) return;
  World alone;
  alone.room = {-1e6, 1e6, -1e6, 1e6, 1e6, {}, {}, {}};
  alone.obstacles = {obstacle};
  if (find_contacts(alone, scenario.robot.footprint, scenario.robot.pose, 0).collision()) {
    node.fault("position", "on the robot at its start", "a place outside the robot's footprint");
  }
}

/// Whether the target straight ahead, so far from the axle, is seen whole and does not touch the robot.
bool usable_distance(const Scenario& scenario, double distance_m) {
  const Camera& camera = scenario.camera.camera;
  const double radius_m = scenario.target_ball().radius_m();
  const Eigen::Vector3d p_RB(distance_m, 0, scenario.target_ball().position_m.z());
  const Eigen::Vector3d p_CB = scenario.camera.mount.X_RC().inverse() * p_RB;
  return distance_m > scenario.robot.footprint.front_m + radius_m &&
         is_inside_picture(project_outline(camera, p_CB, radius_m, 72), camera.size(), 0.5);
}

/// All such distances, to 1 cm, in words; none beyond 20 m are looked for.
std::string usable_distances(const Scenario& scenario) {
  std::string text;
  for (int from_cm = 5, cm = 5; cm <= 2001; ++cm) {
    if (cm <= 2000 && usable_distance(scenario, cm / 100.0)) continue;
    if (cm > from_cm)
      text +=
          fmt::format("{}{:.2f} to {:.2f} m", text.empty() ? "" : ", or ", from_cm / 100.0, (cm - 1) / 100.0);
    from_cm = cm + 1;
  }
  return text.empty() ? "no distance would do with this camera, mount and ball: change one of them"
                      : text + " (the ball whole in the picture, clear of the robot)";
}

}  // namespace

void check_scenario(StrictYaml& yaml, const Scenario& scenario, const WorldOptions& reading,
                    const ScenarioReading& parts) {
  YamlNode root = yaml.root();
  const World& world = reading.world;
  const std::vector<YamlNode> balls = root.list("balls"), obstacles = root.list("obstacles");
  for (std::size_t k = 0; k < balls.size(); ++k) {
    if (reading.ball_ok[k]) check_ball(balls[k], k, scenario, reading, parts);
  }
  for (std::size_t k = 0; k < world.obstacles.size(); ++k) {
    if (!reading.obstacle_ok[k]) continue;
    check_obstacle(obstacles[reading.obstacle_item[k]], world.obstacles[k], scenario, reading, parts);
  }
  if (reading.room_ok && parts.robot_ok) {
    World empty;
    empty.room = world.room;
    if (find_contacts(empty, scenario.robot.footprint, scenario.robot.pose, 0).collision()) {
      root.map("robot").fault("pose", "a robot in a wall or outside the room", "a place clear of the walls");
    } else if (parts.mount_ok &&
               !inside_room(world.room, scenario.X_WC(scenario.robot.pose).translation(), 0.01)) {
      root.map("camera").fault("mount", "a camera outside the room", "a place inside the room");
    }
  }
  for (std::size_t k = 0; reading.room_ok && k < world.lights.size(); ++k) {
    if (!inside_room(world.room, world.lights[k].position_m, 0)) {
      root.fault("lights", position_text(world.lights[k].position_m) + ": outside the room",
                 "lights inside the room");
    }
  }
  if (parts.camera_ok && parts.mount_ok && parts.target_ok && reading.ball_ok[scenario.target] &&
      !usable_distance(scenario, scenario.target_distance_m)) {
    root.map("target").fault(
        "distance_m",
        fmt::format("{} m, where the ball is not whole in the picture or touches the robot",
                    scenario.target_distance_m),
        usable_distances(scenario));
  }
}

}  // namespace ballservo
