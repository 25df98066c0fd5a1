#include "app/experiment/control_loop.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "app/experiment/cpu_clock.hpp"
#include "app/scenario/time_optimal.hpp"
#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

ControlLoop::ControlLoop(const Scenario& scenario, const ControllerOptions& controller,
                         const ReachedRule& rule)
    : scenario_(scenario),
      controller_(controller, builtin_laws().make(scenario.law, controller.goal)),
      judge_(scenario.duration_s, !std::holds_alternative<StaticMotion>(scenario.target_ball().motion),
             rule) {
  run_.steps.reserve(static_cast<std::size_t>(std::min(scenario.duration_s * scenario.control_rate_hz, 1e4)) +
                     2);
}

void ControlLoop::hear(const SeenFrame& frame) {
  // The robot stamps a frame with its arrival less the latency that it believes.
  BallMeasurement heard_of = frame.record.measurement;
  heard_of.time_s -= scenario_.believed.latency_error_s;
  controller_.see(heard_of, frame.arrives_s);
  if (frame.floor.count > 0) {
    FloorScan floor = frame.floor;
    floor.time_s = heard_of.time_s;
    controller_.see(floor);
  }
  perception_ms_ = frame.perception_ms;
  heard_ = true;
}

/// What is true at a control step, whatever the robot believes.
StepRecord ControlLoop::observe(const RobotView& robot) const {
  StepRecord record;
  record.step = static_cast<long>(run_.steps.size());
  record.time_s = robot.time_s;
  record.pose = robot.pose;
  record.twist = robot.twist;
  record.odometry = robot.odometry;
  record.p_WB = scenario_.target_ball().p_WB(record.time_s);
  const Eigen::Vector2d p_RB = in_robot_frame(record.pose, record.p_WB.head<2>());
  record.range_m = p_RB.norm();
  record.range_error_m = record.range_m - scenario_.target_distance_m;
  record.bearing_rad = std::atan2(p_RB.y(), p_RB.x());
  const Eigen::Isometry3d X_WC = scenario_.X_WC(record.pose);
  const Eigen::Vector3d p_CB = X_WC.inverse() * record.p_WB;
  const Eigen::Vector3d away = record.p_WB - X_WC.translation();
  const double distance_m = away.norm();
  record.hidden =
      distance_m > 0 &&
      Scene(scenario_.world, record.time_s).hit_solids(X_WC.translation(), away / distance_m, distance_m) <
          distance_m;
  if (const auto pixel = scenario_.camera.camera.project(p_CB)) {
    const ImageSize size = scenario_.camera.camera.size();
    record.in_view = pixel->x() >= -0.5 && pixel->x() <= size.width_px - 0.5 && pixel->y() >= -0.5 &&
                     pixel->y() <= size.height_px - 0.5;
  }
  return record;
}

/// What the robot has run into; empty: nothing. Touching the target is none of it (the judge counts that),
/// nor is a ball that lies under the sonars' beam; any other ball is a thing like others, unless it came to a
/// robot at rest.
std::string ControlLoop::collided_with(const ContactReport& contacts, const Twist2& twist) const {
  if (contacts.collision()) return contacts.nearest;
  const bool moves = std::abs(twist.v_mps) >= 1e-3 || std::abs(twist.w_radps) >= 1e-3;
  if (!contacts.ball_contact() || !moves || contacts.nearest_ball == scenario_.target_ball().name) return "";
  const Ball* ball = scenario_.world.find_ball(contacts.nearest_ball);
  return ball != nullptr && ball->sonar ? contacts.nearest_ball : "";
}

Twist2 ControlLoop::step(const RobotView& robot) {
  StepRecord record = observe(robot);
  const ContactReport contacts =
      find_contacts(scenario_.world, scenario_.robot.footprint, robot.pose, robot.time_s);
  record.clearance_m = contacts.clearance_m;
  record.ball_clearance_m = contacts.ball_clearance_m;

  const double before_s = thread_cpu_s();
  record.control = controller_.step(robot.time_s, robot.odometry, robot.measured_twist);
  const double control_us = (thread_cpu_s() - before_s) * 1e6;
  run_.timing.control_us.push_back(control_us);
  if (heard_) run_.timing.image_to_command_ms.push_back(perception_ms_ + control_us * 1e-3);
  heard_ = false;

  const std::string touched = collided_with(contacts, robot.twist);
  judge_.look(record, touched);
  if (touched_.empty()) touched_ = touched;
  run_.steps.push_back(record);
  return record.control.command;
}

RunRecord ControlLoop::finish(bool interrupted) {
  run_.summary = judge_.summary(run_.steps, interrupted && !judge_.over());
  run_.summary.time_optimal_s =
      time_optimal_s(scenario_.robot.pose, scenario_.target_ball().p_WB(0).head<2>(),
                     scenario_.target_distance_m, scenario_.robot.limits);
  return std::move(run_);
}

}  // namespace ballservo
