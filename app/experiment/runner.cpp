#include "app/experiment/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "app/experiment/collision_cause.hpp"
#include "app/experiment/control_loop.hpp"
#include "app/experiment/picture_keeper.hpp"
#include "app/io/ball_rows.hpp"

namespace ballservo {

ControllerOptions controller_options(const Scenario& scenario) {
  ControllerOptions options;
  options.rate_hz = scenario.control_rate_hz;
  options.latency_s = scenario.camera.latency_s + scenario.believed.latency_error_s;
  options.actuation_delay_s = scenario.robot.actuation_delay_s;
  options.limits = scenario.robot.limits;
  options.goal = scenario.goal();
  options.turn_gain_per_s = scenario.law.gain_per_s;
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
  RunCamera camera(scenario, options);
  RunRobot robot(scenario, options.seed);
  ControlLoop control(scenario, controller_options(scenario), options.rule);
  PictureKeeper pictures(scenario);
  std::deque<SeenFrame> on_the_way;  // seen, but not yet heard of by the control loop
  std::vector<FrameRecord> frames;
  std::string tracks = ball_rows_header();
  bool interrupted = false;

  for (long step = 0; !control.over() && !interrupted;) {
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
      if (auto frame = camera.expose(camera.next_s(), robot.pose(), tracks)) {
        const auto& steps = control.record().steps;
        pictures.take(frame->record, steps.empty() ? ControlState::search : steps.back().control.state,
                      frame->picture);
        if (options.on_picture && !frame->picture.empty())
          options.on_picture(frame->picture, control.record(), robot.firings());
        frame->picture.release();
        frames.push_back(frame->record);
        on_the_way.push_back(std::move(*frame));
      }
      continue;
    }

    // The control step: hear of what has arrived, decide, command.
    robot.advance_to(step_s);
    for (; !on_the_way.empty() && on_the_way.front().arrives_s <= step_s; on_the_way.pop_front())
      control.hear(on_the_way.front());
    robot.listen([&control](const SonarReading& reading) { control.hear(reading); });
    robot.command(control.step(robot.view()));
    ++step;
    interrupted = options.go_on && !options.go_on(step_s);
  }

  RunRecord run = control.finish(interrupted);
  run.frames = std::move(frames);
  run.tracks_csv = std::move(tracks);
  run.key_frames = pictures.finish();
  if (!control.touched().empty()) {
    run.summary.collision_cause = collision_cause(scenario, {control.touched(), run.steps, robot.firings()});
  }
  return run;
}

}  // namespace ballservo
