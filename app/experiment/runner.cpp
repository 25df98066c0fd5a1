#include "app/experiment/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <variant>

#include "app/experiment/collision_cause.hpp"
#include "app/experiment/run_camera.hpp"
#include "app/experiment/run_robot.hpp"
#include "app/experiment/run_video.hpp"
#include "app/experiment/time_optimal.hpp"
#include "app/io/ball_rows.hpp"
#include "servo/simulation/collision.hpp"

namespace ballservo {

namespace {

constexpr std::size_t max_key_frames = 9;

/// What is true at a control step, whatever the robot believes.
StepRecord observe(const Scenario& scenario, const RunRobot& robot, const ContactReport& contacts,
                   long step) {
  StepRecord record;
  record.step = step;
  record.time_s = robot.time_s();
  record.pose = robot.pose();
  record.twist = robot.twist();
  record.p_WB = scenario.target_ball().p_WB(record.time_s);
  const Eigen::Vector2d p_RB = in_robot_frame(record.pose, record.p_WB.head<2>());
  record.range_m = p_RB.norm();
  record.range_error_m = record.range_m - scenario.target_distance_m;
  record.bearing_rad = std::atan2(p_RB.y(), p_RB.x());
  record.clearance_m = contacts.clearance_m;
  record.ball_clearance_m = contacts.ball_clearance_m;
  const Eigen::Vector3d p_CB = scenario.X_WC(record.pose).inverse() * record.p_WB;
  if (const auto pixel = scenario.camera.camera.project(p_CB)) {
    const ImageSize size = scenario.camera.camera.size();
    record.in_view = pixel->x() >= -0.5 && pixel->x() <= size.width_px - 0.5 && pixel->y() >= -0.5 &&
                     pixel->y() <= size.height_px - 0.5;
  }
  return record;
}

/// The frames' pictures with what was measured drawn in: handed on for videos, and kept where the state
/// changed.
class PictureKeeper {
 public:
  PictureKeeper(const Scenario& scenario, const RunOptions& options)
      : scenario_(scenario), options_(options), radius_m_(scenario.target_ball().radius_m()) {}

  void take(SeenFrame& frame, RunRecord& run) {
    if (frame.picture.empty()) return;
    const ControlState state = run.steps.empty() ? ControlState::search : run.steps.back().control.state;
    std::string text = fmt::format("{:6.2f} s  {}  {}", frame.record.time_s, control_state_name(state),
                                   track_state_name(frame.record.measurement.state));
    if (frame.record.measurement.state != TrackState::none) {
      text += fmt::format("  {:.3f} m", frame.record.measurement.p_CB.norm());
    }
    draw_sight(frame.picture, scenario_.camera.camera, frame.record, radius_m_, text);
    if (options_.on_picture) options_.on_picture(frame.picture, run);
    const bool changed = !last_state_ || *last_state_ != state;
    const bool halfway = state == ControlState::approach && frame.record.time_s >= next_s_;
    if ((changed || halfway) && run.key_frames.size() + 1 < max_key_frames) {
      run.key_frames.push_back({frame.record.time_s, frame.picture.clone(),
                                fmt::format("{:.2f} s: {}", frame.record.time_s, control_state_name(state))});
      next_s_ = frame.record.time_s + 2.5;
    }
    last_state_ = state;
    last_ = {frame.record.time_s, frame.picture,
             fmt::format("{:.2f} s: the last frame", frame.record.time_s)};
  }

  void finish(RunRecord& run) {
    if (!last_.picture.empty()) run.key_frames.push_back(std::move(last_));
  }

 private:
  const Scenario& scenario_;
  const RunOptions& options_;
  double radius_m_, next_s_ = 0;
  std::optional<ControlState> last_state_;
  KeyFrame last_;
};

}  // namespace

ControllerOptions controller_options(const Scenario& scenario) {
  ControllerOptions options;
  options.rate_hz = scenario.control_rate_hz;
  options.latency_s = scenario.camera.latency_s + scenario.believed.latency_error_s;
  options.actuation_delay_s = scenario.robot.actuation_delay_s;
  options.limits = scenario.robot.limits;
  options.goal = scenario.goal();
  options.law = scenario.law;
  options.avoidance = scenario.avoidance;
  // A little less than half the picture, so that the ball stays whole in it.
  const double half_width_px = 0.5 * scenario.camera.camera.size().width_px;
  options.avoidance.steering.half_view_rad =
      0.9 * std::atan(half_width_px / scenario.camera.camera.focal_px());
  return options;
}

std::string gain_warning(const Scenario& scenario) {
  const double rate_hz = std::min(scenario.control_rate_hz, scenario.camera.rate_hz);
  const double delay_s = scenario.camera.latency_s + scenario.robot.actuation_delay_s;
  const double limit_per_s = max_stable_gain_per_s(rate_hz, delay_s);
  if (scenario.law.gain_per_s <= limit_per_s) return "";
  return fmt::format(
      "law.gain_per_s {:.3g} is above {:.3g} (1/s), the largest that is stable at {:.3g} Hz with {:.3g} s of "
      "delay: it "
      "relies wholly on the prediction over the delay, and a wrong latency or a slipping wheel makes it "
      "swing",
      scenario.law.gain_per_s, limit_per_s, rate_hz, delay_s);
}

RunRecord run_closed_loop(const Scenario& scenario, const RunOptions& options) {
  using Clock = std::chrono::steady_clock;
  const Ball& target = scenario.target_ball();

  RunCamera camera(scenario, options);
  Controller controller(controller_options(scenario));
  RunRobot robot(scenario, options.seed);
  OutcomeJudge judge(scenario.duration_s, !std::holds_alternative<StaticMotion>(target.motion), options.rule);
  PictureKeeper pictures(scenario, options);
  std::deque<SeenFrame> on_the_way;  // seen, but not yet heard of by the control loop
  RunRecord run;
  run.tracks_csv = ball_rows_header();
  bool interrupted = false;
  std::string cause;  // of the first collision

  for (long step = 0; !judge.over();) {
    const double step_s = static_cast<double>(step) / scenario.control_rate_hz;

    // The sonars and the camera, whenever a firing or an instant of an exposure is due before the next
    // control step.
    if (robot.next_sonar_s() <= std::min(step_s, camera.next_s())) {
      robot.advance_to(robot.next_sonar_s());
      robot.fire_sonar();
      continue;
    }
    if (camera.next_s() <= step_s) {
      robot.advance_to(camera.next_s());
      if (auto frame = camera.expose(robot.pose(), run.tracks_csv)) {
        run.frames.push_back(frame->record);
        pictures.take(*frame, run);
        frame->picture.release();
        on_the_way.push_back(std::move(*frame));
      }
      continue;
    }

    // The control step: hear of the frames that have arrived, decide, command.
    robot.advance_to(step_s);
    double perception_ms = 0;
    bool heard = false;
    for (; !on_the_way.empty() && on_the_way.front().arrives_s <= step_s; on_the_way.pop_front()) {
      // The robot stamps a frame with its arrival less the latency that it believes.
      BallMeasurement heard_of = on_the_way.front().record.measurement;
      heard_of.time_s -= scenario.believed.latency_error_s;
      controller.see(heard_of);
      perception_ms = on_the_way.front().perception_ms;
      heard = true;
    }
    robot.listen([&controller](const SonarReading& reading) { controller.hear(reading); });
    const ContactReport contacts =
        find_contacts(scenario.world, scenario.robot.footprint, robot.pose(), step_s);
    StepRecord record = observe(scenario, robot, contacts, step);
    const auto before = Clock::now();
    record.control = controller.step(step_s, robot.odometry(), robot.measured_twist());
    const double control_us = std::chrono::duration<double, std::micro>(Clock::now() - before).count();
    robot.command(record.control.command);

    run.timing.control_us.push_back(control_us);
    if (heard) run.timing.image_to_command_ms.push_back(perception_ms + control_us * 1e-3);
    judge.look(record, contacts.collision() ? contacts.nearest : "");
    if (contacts.collision() && cause.empty()) cause = collision_cause(scenario, contacts.nearest, step_s);
    run.steps.push_back(record);
    ++step;
    if (options.go_on && !options.go_on(step_s)) {
      interrupted = !judge.over();
      break;
    }
  }
  pictures.finish(run);
  run.summary = judge.summary(run.steps, interrupted);
  run.summary.collision_cause = cause;
  run.summary.time_optimal_s = time_optimal_s(scenario.robot.pose, target.p_WB(0).head<2>(),
                                              scenario.target_distance_m, scenario.robot.limits);
  return run;
}

}  // namespace ballservo
