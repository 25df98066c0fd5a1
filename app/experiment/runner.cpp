#include "app/experiment/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/experiment/peer_controller.hpp"
#include "app/experiment/peer_robot.hpp"
#include "app/experiment/run_recorder.hpp"
#include "app/experiment/run_video.hpp"
#include "app/loop/threaded_loop.hpp"
#include "calibration/base/fault.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo {

std::string gain_warning(const Scenario& scenario) {
  const double rate_hz = std::min(scenario.control_rate_hz, scenario.camera.rate_hz);
  const double delay_s = scenario.camera.latency_s + scenario.robot.actuation_delay_s;
  const double limit_per_s = max_stable_gain_per_s(rate_hz, delay_s);
  if (scenario.law.gain_per_s <= limit_per_s) return "";
  return fmt::format(
      "law.gain_per_s {:.3g} is above {:.3g} (1/s), the largest that is stable at {:.3g} Hz with {:.3g} s of "
      "delay: it relies wholly on the prediction over the delay, and a wrong latency or a slipping wheel "
      "makes it swing",
      scenario.law.gain_per_s, limit_per_s, rate_hz, delay_s);
}

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
  options.avoidance.half_view_rad = 0.9 * scenario.camera.half_view_rad();
  return options;
}

namespace {

/// The record of a run that is over; `gone`: the peer that ended it, or null.
RunRecord finished(RunRecorder& recorder, const SimulatedPerception& perception, PictureKeeper& pictures,
                   bool realtime, const PeerGone* gone) {
  RunRecord run = recorder.finish(realtime);
  if (gone != nullptr) {
    run.summary.outcome = outcome_from_name(gone->outcome()).value_or(Outcome::fault);
    run.summary.outcome_text = gone->what();
  }
  run.tracks_csv = perception.tracks_csv();
  run.assumed_light = perception.assumed_light();
  run.key_frames = pictures.finish();
  return run;
}

}  // namespace

/// A scenario's ports and observers. Made in its place: they refer to each other.
class SimulatedRun {
 public:
  SimulatedRun(const Scenario& scenario, const RunOptions& options, const ControllerOptions& controller)
      : options_(options),
        untouched_(scenario),
        scenario_(scenario),
        robot_(scenario_.world, scenario.robot, scenario.seed, options.body, scenario.camera.mount.pan),
        camera_(
            scenario_, options.perception == PerceptionLevel::image || options.on_picture,
            [this](double time_s) { return robot_.at(time_s); }, options.take_picture),
        perception_(make_eyes()),
        controller_(make_controller(controller)),
        recorder_(scenario_, robot_, &camera_, bool(options.touch)),
        pictures_(scenario_, show_pictures()) {}

  LoopPorts ports() {
    LoopPorts ports{camera_, *perception_, robot_, *controller_, {&recorder_, &pictures_}};
    if (peer_ != nullptr) ports.observers.push_back(peer_);
    return ports;
  }
  const RunRecord& so_far() const { return recorder_.record(); }

  /// After each control step.
  bool goes_on(double time_s) {
    if (options_.touch && !recorder_.over()) {
      for (const Touch& touch : options_.touch({scenario_, so_far(), robot_.firings(), *controller_}))
        feel(touch);
    }
    if (options_.remembered_steps > 0) {
      recorder_.forget(options_.remembered_steps);
      robot_.forget(options_.remembered_steps);
      perception_->forget();
    }
    if (peer_ != nullptr && !recorder_.over()) peer_->throw_if_gone();
    const bool interrupted = options_.go_on && !options_.go_on(time_s);
    return !interrupted && !recorder_.over();
  }

  RunRecord finish(bool realtime, const PeerGone* gone = nullptr) {
    RunRecord run = finished(recorder_, *perception_, pictures_, realtime, gone);
    if (peer_ != nullptr) peer_->leave(run.summary);
    return run;
  }

 private:
  std::function<void(const cv::Mat&)> show_pictures() const {
    if (!options_.on_picture) return {};
    return [this](const cv::Mat& picture) {
      options_.on_picture(picture, recorder_.record(), robot_.firings());
    };
  }

  std::unique_ptr<SimulatedPerception> make_eyes() {
    if (options_.controller != nullptr && options_.perception == PerceptionLevel::image)
      return std::make_unique<BlindPerception>();
    return make_perception(scenario_, options_.perception, options_.colors, camera_);
  }

  std::unique_ptr<Controller> make_controller(const ControllerOptions& options) {
    auto law = options_.laws.make(scenario_.law, options.goal);
    if (options_.controller == nullptr) return std::make_unique<Controller>(options, std::move(law));
    auto peer = std::make_unique<PeerController>(options, std::move(law), scenario_, *options_.controller);
    peer_ = peer.get();
    return peer;
  }

  void feel(const Touch& touch) {
    touch_scenario(touch, untouched_, scenario_);
    if (touch.kind == Touch::Kind::robot) robot_.put(touch.to);
    robot_.look_around();
    camera_.look_around();
    perception_->look_around();
    const ControllerOptions controller = controller_options(scenario_);
    controller_->retune(controller, options_.laws.make(scenario_.law, controller.goal));
  }

  const RunOptions& options_;
  const Scenario& untouched_;
  Scenario scenario_;
  SimulatedRobot robot_;
  SimulatedCamera camera_;
  std::unique_ptr<SimulatedPerception> perception_;
  PeerController* peer_ = nullptr;  // the controller, where it is one
  std::unique_ptr<Controller> controller_;
  RunRecorder recorder_;
  PictureKeeper pictures_;
};

std::function<std::vector<Touch>(const RunView& now)> replay(Touches touches) {
  return [list = std::move(touches.list), next = std::size_t{0}](const RunView& now) mutable {
    std::vector<Touch> due;
    while (next < list.size() && list[next].step <= now.record.steps.back().step) due.push_back(list[next++]);
    return due;
  };
}

struct SteppedRun::Parts {
  SimulatedRun run;
  LoopPorts ports{run.ports()};
  SteppedClock clock{};
  Loop loop{ports, clock};
  std::unique_ptr<RestAtEnd> rest = std::make_unique<RestAtEnd>(ports.robot, clock);  // until it is over
};

SteppedRun::SteppedRun(const Scenario& scenario, const RunOptions& options)
    : parts_(new Parts{{scenario, options, controller_options(scenario)}}) {}

SteppedRun::~SteppedRun() = default;

bool SteppedRun::step() {
  if (over()) return false;
  auto rest = std::move(parts_->rest);
  if (!parts_->run.goes_on(parts_->loop.advance())) return false;
  parts_->rest = std::move(rest);
  return true;
}

bool SteppedRun::over() const { return !parts_->rest; }
const RunRecord& SteppedRun::so_far() const { return parts_->run.so_far(); }
RunRecord SteppedRun::finish(const PeerGone* gone) {
  parts_->rest.reset();
  return parts_->run.finish(false, gone);
}

RunRecord run_closed_loop(const Scenario& scenario, const RunOptions& options) {
  SteppedRun run(scenario, options);
  try {
    while (run.step()) {
    }
  } catch (const PeerGone& gone) {
    RunRecord record = run.finish(&gone);
    if (record.steps.empty()) throw;
    return record;
  }
  return run.finish();
}

RunRecord run_realtime(const Scenario& scenario, const RunOptions& options) {
  if (options.touch) throw InputError("touch", "on the wall clock", "a run in simulated time");
  if (options.on_picture) {
    throw InputError("on_picture", "a film on the wall clock", "none: drawing it would hold the camera up");
  }
  SimulatedRun run(scenario, options, for_threads(controller_options(scenario)));
  WallClock clock;
  run_threaded_loop(run.ports(), clock, [&](double time_s) { return run.goes_on(time_s); });
  return run.finish(true);
}

RunRecord drive_peer(const Scenario& scenario, const RunOptions& options, LockstepSocket& socket) {
  const bool pictures = options.perception == PerceptionLevel::image;
  const ControllerOptions settings = controller_options(scenario);
  Controller controller(settings, options.laws.make(scenario.law, settings.goal));
  std::unique_ptr<SimulatedPerception> perception;
  if (pictures) perception = make_image_perception(scenario, options.colors);
  PeerRobot robot(socket, scenario, pictures);
  if (!pictures) perception = std::make_unique<PeerPerception>(scenario, robot);
  RunRecorder recorder(scenario, robot, nullptr, false);
  PictureKeeper keeper(scenario);
  SteppedClock clock;
  std::optional<PeerGone> gone;
  try {
    run_loop({robot, *perception, robot, controller, {&recorder, &keeper}}, clock,
             [&](double time_s) { return (!options.go_on || options.go_on(time_s)) && !recorder.over(); });
  } catch (const PeerGone& error) {
    gone = error;
  }
  RunRecord run = finished(recorder, *perception, keeper, false, gone ? &*gone : nullptr);
  robot.leave(run.summary.outcome_text);
  if (gone && run.steps.empty()) throw PeerGone(*gone);
  return run;
}

namespace {

/// The scenario with its robot at the goal and its ball at rest.
Scenario at_the_goal(const Scenario& scenario) {
  Scenario there = scenario;
  Ball& ball = there.world.balls[there.target];
  ball.position_m = ball.p_WB(0);
  ball.motion = StaticMotion{};
  const Pose2 start = scenario.robot.pose;
  const Eigen::Vector2d p_WB = ball.position_m.head<2>();
  const Eigen::Vector2d way = p_WB - Eigen::Vector2d(start.x_m, start.y_m);
  const double yaw_rad = std::atan2(way.y(), way.x());
  const Eigen::Vector2d goal =
      p_WB - scenario.target_distance_m * Eigen::Vector2d(std::cos(yaw_rad), std::sin(yaw_rad));
  there.robot.pose = {goal.x(), goal.y(), yaw_rad};
  // Believed, not known: with a goal that was taught the ball's direction alone tells it from another thing.
  const ServoGoal believed = there.goal();
  there.taught_center_over_radius = believed.desired_p_CB() / believed.ball_radius_m;
  return there;
}

void check_clear(const Scenario& there) {
  const ContactReport contacts = find_contacts(there.world, there.robot.footprint, there.robot.pose, 0);
  if (!contacts.collision() && !contacts.ball_contact()) return;
  throw Refusal(
      fmt::format("cannot teach: at the goal, ({:.2f}, {:.2f}) m, the robot would touch {}; move it, or "
                  "start the robot elsewhere (--set robot.pose.x_m=...)",
                  there.robot.pose.x_m, there.robot.pose.y_m,
                  contacts.collision() ? contacts.nearest : contacts.nearest_ball));
}

}  // namespace

TaughtTarget teach_target(const Scenario& scenario, const TeachOptions& options) {
  const Scenario there = at_the_goal(scenario);
  check_clear(there);
  SimulatedCamera camera(there, options.perception == PerceptionLevel::image, [&there](double time_s) {
    return RobotTruth{time_s, there.robot.pose, {}};
  });
  const auto perception = make_perception(there, options.perception, options.colors, camera);
  SteppedClock clock;
  std::vector<Eigen::Vector3d> seen;
  for (int frame = 0; frame < options.frames;) {
    if (options.progress) options.progress(frame);
    const auto exposed = camera.take(clock, camera.next_start_s() + there.camera.exposure_s);
    if (!exposed) continue;
    ++frame;
    const BallMeasurement ball = perception->look(*exposed).ball;
    if (ball.state == TrackState::confirmed) seen.push_back(ball.p_CB / there.goal().ball_radius_m);
  }
  if (2 * seen.size() < static_cast<std::size_t>(options.frames)) {
    throw Refusal(fmt::format(
        "nothing taught: standing at the goal, the robot was sure of ball {} in {} of {} frames only; look "
        "at what the camera sees there (render), at the colours, and at what hides the ball",
        there.target_ball().name, seen.size(), options.frames));
  }
  TaughtTarget target;
  target.ball = there.target_ball().name;
  target.frames = static_cast<int>(seen.size());
  target.distance_m = scenario.target_distance_m;
  for (const Eigen::Vector3d& each : seen) target.center_over_radius += each / target.frames;
  Eigen::Array3d variance = Eigen::Array3d::Zero();
  for (const Eigen::Vector3d& each : seen) {
    variance += (each - target.center_over_radius).array().square() / std::max(1, target.frames - 1);
  }
  target.sigma = (variance / target.frames).sqrt();
  return target;
}

}  // namespace ballservo
