#include "app/experiment/collision_cause.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "servo/motion/motion_history.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo {

namespace {

using Points = std::vector<Eigen::Vector2d>;
constexpr double contact_m = 0.01;  // how near to the footprint a point of what was touched counts as touched
constexpr double corner_m = 0.37;   // of the footprint, from the axle

/// The outline of what was touched, every few millimetres.
Points obstacle_outline(const World& world, const std::string& touched, const Eigen::Vector2d& near_W) {
  Points points;
  const auto along = [&points](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const int count = std::max(1, static_cast<int>((b - a).norm() / 0.005));
    for (int k = 0; k <= count; ++k) points.push_back(a + (b - a) * k / count);
  };
  const auto obstacle = find_named(world.obstacles, touched);
  if (obstacle == world.obstacles.end()) {
    const Room& room = world.room;
    for (const double x : {room.x_min_m, room.x_max_m}) along({x, near_W.y() - 1}, {x, near_W.y() + 1});
    for (const double y : {room.y_min_m, room.y_max_m}) along({near_W.x() - 1, y}, {near_W.x() + 1, y});
    return points;
  }
  const FloorOutline outline = floor_outline(*obstacle);
  if (outline.radius_m > 0) {
    const int count = std::max(8, static_cast<int>(2 * M_PI * outline.radius_m / 0.005));
    for (int k = 0; k < count; ++k) {
      const double angle = 2 * M_PI * k / count;
      points.push_back(outline.points_m.front() +
                       outline.radius_m * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    return points;
  }
  for (std::size_t k = 0; k < outline.points_m.size(); ++k) {
    along(outline.points_m[k], outline.points_m[(k + 1) % outline.points_m.size()]);
  }
  return points;
}

Points contact_points(const Scenario& scenario, const std::string& touched, const Pose2& pose) {
  Points points = obstacle_outline(scenario.world, touched, {pose.x_m, pose.y_m});
  points.erase(std::remove_if(points.begin(), points.end(),
                              [&](const Eigen::Vector2d& p) {
                                return scenario.robot.footprint.distance_m(in_robot_frame(pose, p)) >
                                       contact_m;
                              }),
               points.end());
  return points;
}

/// The first step that the occupancy grid, which counts motion only, still reaches.
std::size_t first_remembered(const std::vector<StepRecord>& steps, double memory_s) {
  double motion_s = 0;
  std::size_t k = steps.size() - 1;
  for (; k > 0 && motion_s <= memory_s; --k) {
    if (!steps[k].twist.rests()) motion_s += steps[k].time_s - steps[k - 1].time_s;
  }
  return k;
}

/// Whether an answer says that nothing is at a point that lies in its cone, by the measure of OccupancyGrid.
bool denies(const SonarFiring& firing, const Eigen::Vector2d& p_W, const OccupancyGridOptions& grid) {
  const SonarMount& mount = pioneer_3dx_sonars[firing.reading.transducer];
  const Eigen::Vector2d away = p_W - in_world_frame(firing.pose, {mount.x_m, mount.y_m});
  const double aside = wrap_angle(std::atan2(away.y(), away.x()) - firing.pose.yaw_rad - mount.heading_rad);
  return firing.reading.range_m > grid.beam.min_range_m &&
         std::abs(aside) <= grid.beam.half_angle_rad - OccupancyGrid::angle_error_rad &&
         away.norm() <= std::min(firing.reading.range_m - grid.range_error_m, grid.look_range_m);
}

bool faulty(const Scenario& scenario, const SonarFiring& firing) {
  const auto& faults = scenario.robot.sonar_faults;
  return std::any_of(faults.begin(), faults.end(), [&](const SonarFault& fault) {
    return fault.transducer == firing.reading.transducer && fault.from_s <= firing.reading.fired_s;
  });
}

/// A3 or A4, where two firings of a transducer in a row denied a point that is there.
std::optional<std::string> denied(const Scenario& scenario, const std::vector<SonarFiring>& firings,
                                  double since_s, const Points& points) {
  bool by_fault = false;
  for (const Eigen::Vector2d& p : points) {
    std::array<const SonarFiring*, sonar_count> before{};
    for (const SonarFiring& firing : firings) {
      const SonarFiring*& last = before[firing.reading.transducer];
      const SonarFiring* previous = std::exchange(last, nullptr);
      if (firing.reading.fired_s < since_s || !denies(firing, p, scenario.avoidance.grid)) continue;
      last = &firing;
      if (previous == nullptr) continue;
      if (!faulty(scenario, firing) && !faulty(scenario, *previous)) return "A3_echo";
      by_fault = true;
    }
  }
  return by_fault ? std::make_optional<std::string>("A4_range") : std::nullopt;
}

/// Whether odometry's error about a point, from some time up to the end, exceeds the bound.
bool odometry_exceeded(const Scenario& scenario, const std::vector<StepRecord>& steps, std::size_t first,
                       const Points& points) {
  constexpr double rounding_m = 1e-6;
  const StepRecord& end = steps.back();
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d p_now = in_robot_frame(end.pose, p);
    double path_m = 0, turn_rad = 0;
    for (std::size_t k = steps.size() - 1; k-- > first;) {
      path_m += distance_m(steps[k].odometry, steps[k + 1].odometry);
      turn_rad += std::abs(wrap_angle(steps[k + 1].odometry.yaw_rad - steps[k].odometry.yaw_rad));
      const Eigen::Vector2d p_then = in_robot_frame(steps[k].pose, p);
      const Eigen::Vector2d p_believed =
          in_robot_frame(end.odometry, in_world_frame(steps[k].odometry, p_then));
      const double bound_m =
          scenario.robot.odometry.bound.point_error_m(path_m, turn_rad, p_now.norm()) * 1.001;
      if ((p_believed - p_now).norm() > bound_m + rounding_m) return true;
    }
  }
  return false;
}

/// Whether the drive, from some step of the last seconds on, went elsewhere than its model foretells.
bool drive_strayed(const Scenario& scenario, const std::vector<StepRecord>& steps) {
  const StepRecord& end = steps.back();
  for (const double ago_s : {0.5, 1.0, 2.0, 3.0, 4.0, 5.0}) {
    const auto from = std::find_if(steps.begin(), steps.end(),
                                   [&](const StepRecord& step) { return step.time_s >= end.time_s - ago_s; });
    const double span_s = end.time_s - from->time_s;
    // Commands that take effect when they did, for a predictor that looks as far ahead as the end.
    MotionPredictor predictor(scenario.robot.limits, span_s, steps.size() + 1);
    for (const StepRecord& step : steps) {
      predictor.add_command(step.time_s + scenario.robot.actuation_delay_s - span_s, step.control.command);
    }
    const Pose2 foretold = predictor.predict(from->time_s, {from->pose, from->twist}).pose;
    const double error_m =
        distance_m(end.pose, foretold) + corner_m * std::abs(wrap_angle(foretold.yaw_rad - end.pose.yaw_rad));
    if (error_m > drive_model_m) return true;
  }
  return false;
}

/// Whether it moved, up to the end, and not as the robot was told to reckon with.
bool moves_otherwise(const Ball& ball, const MovingThingOptions& reckoned, double end_s) {
  if (std::holds_alternative<StaticMotion>(ball.motion)) return false;
  if (ball.radius_m() < reckoned.radius_m) return true;
  constexpr double step_s = 0.1, rounding_mps = 1e-6;
  for (double time_s = 0; time_s < end_s; time_s += step_s) {
    const double way_m = (ball.p_WB(time_s + step_s) - ball.p_WB(time_s)).norm();
    if (way_m > (reckoned.speed_mps + rounding_mps) * step_s) return true;
  }
  return false;
}

/// Whether a command that may have led here passed by the rule of creeping away.
bool crept(const std::vector<StepRecord>& steps) {
  constexpr double brake_s = 1.0;  // more than the delay and a brake from creeping speed
  return std::any_of(steps.begin(), steps.end(), [&](const StepRecord& step) {
    return step.time_s >= steps.back().time_s - brake_s && step.control.shield == creeping_reason;
  });
}

}  // namespace

std::string collision_cause(const Scenario& scenario, const CollisionEvidence& evidence) {
  const RobotSettings& robot = scenario.robot;
  const World& world = scenario.world;
  const std::vector<StepRecord>& steps = evidence.steps;
  if (scenario.avoidance.type == AvoidanceOptions::Type::none || !robot.sonar) return "A1_shield";
  const auto ball = find_named(world.balls, evidence.touched);
  if (ball != world.balls.end() && moves_otherwise(*ball, scenario.avoidance.moving, steps.back().time_s))
    return "A2_static";
  const auto thing = find_named(world.obstacles, evidence.touched);
  if (thing != world.obstacles.end() &&
      (thing->bottom_m() > robot.sonar->height_m || thing->top_m() < robot.sonar->height_m)) {
    return "A3_echo";
  }

  const Points points = contact_points(scenario, evidence.touched, steps.back().pose);
  const std::size_t first = first_remembered(steps, scenario.avoidance.grid.memory_s);
  if (auto cause = denied(scenario, evidence.firings, steps[first].time_s, points)) return *cause;
  if (odometry_exceeded(scenario, steps, first, points)) return "A5_odometry";
  if (drive_strayed(scenario, steps)) return "A6_drive";
  const Eigen::Vector2d start(robot.pose.x_m, robot.pose.y_m);
  const double clear_m = scenario.avoidance.grid.start_clear_m;
  if (std::any_of(points.begin(), points.end(),
                  [&](const Eigen::Vector2d& p) { return (p - start).norm() < clear_m; })) {
    return "A7_start";
  }
  return crept(steps) ? "A8_creep" : "none_broken";
}

}  // namespace ballservo
