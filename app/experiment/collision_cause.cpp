#include "app/experiment/collision_cause.hpp"

#include <algorithm>

#include "servo/simulation/collision.hpp"

namespace ballservo {

namespace {

bool crosses_beam(const Obstacle& obstacle, double height_m) {
  return obstacle.bottom_m() <= height_m && obstacle.top_m() >= height_m;
}

/// Whether a sonar says what is not so: silent ones do no harm.
bool lies(const SonarFault& fault, double time_s) {
  return fault.from_s <= time_s && fault.kind != SonarFault::Kind::dead;
}

}  // namespace

std::string collision_cause(const Scenario& scenario, const std::string& touched, double time_s) {
  const RobotSettings& robot = scenario.robot;
  if (scenario.avoidance.type == AvoidanceOptions::Type::none || !robot.sonar) return "A1_shield";
  const auto& obstacles = scenario.world.obstacles;
  const auto thing = std::find_if(obstacles.begin(), obstacles.end(),
                                  [&](const Obstacle& obstacle) { return obstacle.name == touched; });
  if (thing != obstacles.end() && !crosses_beam(*thing, robot.sonar->height_m)) return "A3_echo";
  if (robot.sonar->dropout_rate > 0 || robot.sonar->specular_limit_rad < 1.57) return "A3_echo";
  const auto& faults = robot.sonar_faults;
  if (std::any_of(faults.begin(), faults.end(), [=](const SonarFault& f) { return lies(f, time_s); })) {
    return "A4_range";
  }
  if (robot.odometry.excess > 1) return "A5_odometry";
  const double near_m = find_contacts(scenario.world, {0, 0, 0}, robot.pose, 0).clearance_m;
  if (near_m < scenario.avoidance.space.start_clear_m) return "A7_start";
  return "none_broken";
}

}  // namespace ballservo
