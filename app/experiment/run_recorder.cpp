#include "app/experiment/run_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "app/experiment/collision_cause.hpp"
#include "app/scenario/feasibility.hpp"
#include "servo/simulation/rendering/scene.hpp"

namespace ballservo {

RunRecorder::RunRecorder(const Scenario& scenario, const WatchedRobot& robot, const SimulatedCamera* camera,
                         bool touched)
    : scenario_(scenario),
      robot_(robot),
      camera_(camera),
      judge_(scenario.duration_s,
             touched || !std::holds_alternative<StaticMotion>(scenario.target_ball().motion)) {
  run_.steps.reserve(static_cast<std::size_t>(std::min(scenario.duration_s * scenario.control_rate_hz, 1e4)) +
                     2);
}

void RunRecorder::frame(const FrameEvent& event) {
  FrameRecord record;
  record.frame = static_cast<int>(event.frame.number);
  record.time_s = event.frame.time_s;
  record.arrived_s = event.arrived_s;
  if (camera_ != nullptr) {
    const BallTruth& target = camera_->truth().target;
    record.view = camera_->truth().view;
    record.truth = target.outline;
    record.truth_p_CB = target.p_CB;
    record.visible_fraction = target.visible_fraction;
  }
  record.measurement = event.percept.ball;
  record.measured = event.percept.outline;
  run_.frames.push_back(record);
  wall_.frame_age_ms.push_back((event.arrived_s - event.frame.time_s) * 1e3);
  if (event.arrived_s > event.frame.arrives_s) ++wall_.frames_late;
}

/// What is true at a control step, whatever the robot believes.
void RunRecorder::observe(const RobotTruth& robot, StepRecord& record) const {
  record.pose = robot.pose;
  record.twist = robot.twist;
  record.pan = robot.pan;
  record.p_WB = scenario_.target_ball().p_WB(record.time_s);
  const Eigen::Vector2d p_RB = in_robot_frame(record.pose, record.p_WB.head<2>());
  record.range_m = p_RB.norm();
  record.range_error_m = record.range_m - scenario_.target_distance_m;
  record.bearing_rad = std::atan2(p_RB.y(), p_RB.x());
  const Eigen::Isometry3d X_WC = scenario_.X_WC(record.pose, record.pan.angle_rad);
  const Eigen::Vector3d away = record.p_WB - X_WC.translation();
  const double distance_m = away.norm();
  record.hidden =
      distance_m > 0 &&
      Scene(scenario_.world, record.time_s).hit_solids(X_WC.translation(), away / distance_m, distance_m) <
          distance_m;
  record.in_view = scenario_.camera.camera.shows(X_WC.inverse() * record.p_WB);
}

/// What the robot has run into; empty: nothing. Touching the target is none of it (the judge counts that),
/// nor is a ball that lies under the sonars' beam; any other ball is a thing like others, unless it came to a
/// robot at rest.
std::string RunRecorder::collided_with(const ContactReport& contacts, const Twist2& twist) const {
  if (contacts.collision()) return contacts.nearest;
  const bool moves = std::abs(twist.v_mps) >= 1e-3 || std::abs(twist.w_radps) >= 1e-3;
  if (!contacts.ball_contact() || !moves || contacts.nearest_ball == scenario_.target_ball().name) return "";
  return find_named(scenario_.world.balls, contacts.nearest_ball)->sonar ? contacts.nearest_ball : "";
}

void RunRecorder::step(const StepEvent& event) {
  StepRecord record;
  record.step = event.step;
  record.time_s = event.robot.time_s;
  record.twist = event.robot.twist;
  record.pan = event.robot.pan;
  record.odometry = event.robot.odometry;
  record.control = event.control;
  std::string touched;
  if (const auto truth = robot_.when_read()) {
    observe(*truth, record);
    const ContactReport contacts =
        find_contacts(scenario_.world, scenario_.robot.footprint, record.pose, record.time_s);
    record.clearance_m = contacts.clearance_m;
    record.ball_clearance_m = contacts.ball_clearance_m;
    touched = collided_with(contacts, record.twist);
  } else {
    record.known = false;
    record.pose = {not_known, not_known, not_known};
    record.p_WB.setConstant(not_known);
    record.range_error_m = record.range_m = record.bearing_rad = not_known;
    record.clearance_m = record.ball_clearance_m = not_known;
  }

  run_.timing.control_us.push_back(event.control_s * 1e6);
  if (std::isfinite(event.perception_s))
    run_.timing.image_to_command_ms.push_back((event.perception_s + event.control_s) * 1e3);
  if (!run_.steps.empty())
    wall_.control_period_ms.push_back((record.time_s - run_.steps.back().time_s) * 1e3);
  wall_.steps_skipped += event.skipped;

  judge_.look(record, touched);
  if (touched_.empty()) touched_ = touched;
  run_.steps.push_back(record);
}

void RunRecorder::guard_looked(double time_s) {
  wall_.guard_period_ms.push_back((time_s - guard_looked_s_) * 1e3);
  guard_looked_s_ = time_s;
}

void RunRecorder::forget(std::size_t most) {
  forget_before_last(most, run_.steps);
  forget_before_last(most, run_.frames);
  for (std::vector<double>* times : {&run_.timing.control_us, &run_.timing.image_to_command_ms,
                                     &wall_.frame_age_ms, &wall_.control_period_ms})
    forget_before_last(most, *times);
}

RunRecord RunRecorder::finish(bool realtime) {
  run_.summary = judge_.summary(run_.steps, !judge_.over());
  if (run_.steps.empty() || run_.steps.back().known)
    run_.summary.time_optimal_s =
        time_optimal_s(scenario_.robot.pose, scenario_.target_ball().p_WB(0).head<2>(),
                       scenario_.target_distance_m, scenario_.robot.limits);
  if (!touched_.empty())
    run_.summary.collision_cause =
        camera_ != nullptr ? collision_cause(scenario_, {touched_, run_.steps, robot_.firings()}) : "unknown";
  if (realtime) {
    wall_.frames_skipped = camera_->skipped();
    run_.timing.realtime = std::move(wall_);
  }
  return std::move(run_);
}

}  // namespace ballservo
