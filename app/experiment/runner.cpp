#include "app/experiment/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/experiment/picture_keeper.hpp"
#include "app/experiment/run_recorder.hpp"
#include "app/loop/threaded_loop.hpp"
#include "calibration/base/fault.hpp"

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
  options.avoidance.half_view_rad = 0.9 * std::atan(half_width_px / scenario.camera.camera.focal_px());
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

namespace {

/// A scenario's ports and observers. Made in its place: they refer to each other.
class SimulatedRun {
 public:
  SimulatedRun(const Scenario& scenario, const RunOptions& options, const ControllerOptions& controller)
      : options_(options),
        robot_(scenario.world, scenario.robot, options.seed),
        camera_(scenario, options.seed, options.perception == PerceptionLevel::image || options.on_picture,
                [this](double time_s) { return robot_.at(time_s); }),
        perception_(make_perception(scenario, options.perception, options.seed, options.colors, camera_)),
        controller_(controller, options.laws.make(scenario.law, controller.goal)),
        recorder_(scenario, robot_, camera_, options.rule),
        pictures_(scenario, [this](const cv::Mat& picture) {
          if (options_.on_picture) options_.on_picture(picture, recorder_.record(), robot_.firings());
        }) {}

  /// `loop` runs the ports until it is told to stop.
  template <typename RunLoop>
  RunRecord run(bool realtime, const RunLoop& loop) {
    bool interrupted = false;
    loop(LoopPorts{camera_, *perception_, robot_, controller_, {&recorder_, &pictures_}}, [&](double time_s) {
      interrupted = options_.go_on && !options_.go_on(time_s);
      return !interrupted && !recorder_.over();
    });
    RunRecord run = recorder_.finish(interrupted, realtime);
    run.tracks_csv = perception_->tracks_csv();
    run.key_frames = pictures_.finish();
    return run;
  }

 private:
  const RunOptions& options_;
  SimulatedRobot robot_;
  SimulatedCamera camera_;
  std::unique_ptr<SimulatedPerception> perception_;
  Controller controller_;
  RunRecorder recorder_;
  PictureKeeper pictures_;
};

}  // namespace

RunRecord run_closed_loop(const Scenario& scenario, const RunOptions& options) {
  return SimulatedRun(scenario, options, controller_options(scenario))
      .run(false, [](const LoopPorts& ports, const GoOn& go_on) {
        SteppedClock clock;
        run_loop(ports, clock, go_on);
      });
}

RunRecord run_realtime(const Scenario& scenario, const RunOptions& options) {
  if (options.on_picture) {
    throw InputError("on_picture", "a film on the wall clock", "none: drawing it would hold the camera up");
  }
  return SimulatedRun(scenario, options, for_threads(controller_options(scenario)))
      .run(true, [](const LoopPorts& ports, const GoOn& go_on) {
        WallClock clock;
        run_threaded_loop(ports, clock, go_on);
      });
}

}  // namespace ballservo
