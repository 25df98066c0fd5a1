#include "app/live/scenario_session.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <mutex>
#include <optional>
#include <utility>

#include "app/experiment/run_log.hpp"
#include "app/experiment/run_video.hpp"
#include "app/io/interrupt.hpp"
#include "app/live/client_words.hpp"
#include "app/live/newest_job.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "servo/simulation/rendering/sensor.hpp"

namespace ballservo {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

constexpr auto between_moments = 33ms, most_behind = 200ms;
constexpr double longest_run_s = 3600, trail_step_s = 0.2, beam_shown_s = 0.4;
constexpr double sigmas_95 = 2.4477468306808161;  // of an ellipse in the plane

Json point(const Eigen::Vector2d& p) { return {p.x(), p.y()}; }

std::string hex(const Rgb& color) {
  const auto byte = [](double value) {
    return static_cast<int>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", byte(color.x()), byte(color.y()), byte(color.z()));
}

Json obstacles_of(const World& world) {
  Json listed = Json::array();
  for (const Obstacle& obstacle : world.obstacles) {
    const FloorOutline outline = floor_outline(obstacle);
    listed.push_back({{"name", obstacle.name},
                      {"center", point(obstacle.center_m.head<2>())},
                      {"points", points_json(outline.points_m)},
                      {"radius_m", outline.radius_m}});
  }
  return listed;
}

Json balls_of(const Scenario& scenario, double time_s) {
  Json listed = Json::array();
  for (const Ball& ball : scenario.world.balls)
    listed.push_back({{"center", point(ball.p_WB(time_s).head<2>())},
                      {"radius_m", ball.radius_m()},
                      {"color", hex(ball.material.texture.color)},
                      {"target", &ball == &scenario.target_ball()}});
  return listed;
}

/// Where the camera is, where it looks, and how far to either side it sees.
Json view_of(const Scenario& scenario, const StepRecord& step) {
  const CameraSettings& camera = scenario.camera;
  const Eigen::Vector2d apex = in_world_frame(step.pose, {camera.mount.forward_m, 0.0});
  return {apex.x(), apex.y(), step.pose.yaw_rad + step.pan.angle_rad, camera.half_view_rad()};
}

/// Where the odometry's frame truly lies: X_WO.
Pose2 odometry_frame(const StepRecord& step) {
  const double yaw_rad = step.pose.yaw_rad - step.odometry.yaw_rad;
  const Eigen::Vector2d turned =
      in_world_frame({0, 0, yaw_rad}, Eigen::Vector2d(step.odometry.x_m, step.odometry.y_m));
  return {step.pose.x_m - turned.x(), step.pose.y_m - turned.y(), yaw_rad};
}

/// What the robot's memory holds to be free around it: a bit a cell, row by row from the lowest y.
Json free_space(const OccupancyGrid& grid, const Pose2& X_WO) {
  constexpr int size = OccupancyGrid::size;
  const FloorCell middle = OccupancyGrid::cell_at(grid.pose().x_m, grid.pose().y_m);
  const int column = middle.column - size / 2, row = middle.row - size / 2;
  std::string bits(static_cast<std::size_t>(size * size / 8), '\0');
  for (int k = 0; k < size * size; ++k) {
    if (grid.is_free({column + k % size, row + k / size}))
      bits[static_cast<std::size_t>(k / 8)] |= static_cast<char>(1 << (k % 8));
  }
  return {{"frame", {X_WO.x_m, X_WO.y_m, X_WO.yaw_rad}},
          {"low_m", {column * OccupancyGrid::cell_m, row * OccupancyGrid::cell_m}},
          {"cell_m", OccupancyGrid::cell_m},
          {"size", size},
          {"bits", base64(bits)}};
}

/// Where the robot holds the ball to be: the 95 % ellipse.
Json ellipse_of(const TargetEstimate& estimate, const Pose2& X_WO) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(estimate.covariance_m2.topLeftCorner<2, 2>());
  const Eigen::Array2d half_m = sigmas_95 * axes.eigenvalues().array().max(0).sqrt();
  const Eigen::Vector2d along = axes.eigenvectors().col(1);
  return {{"center", point(in_world_frame(X_WO, Eigen::Vector2d(estimate.p_OB.head<2>())))},
          {"half_m", {half_m[1], half_m[0]}},
          {"yaw_rad", X_WO.yaw_rad + std::atan2(along.y(), along.x())}};
}

/// Each transducer's last answer: from where, in which direction, how far, whether something was heard.
Json beams_of(const std::vector<SonarFiring>& firings, double time_s) {
  Json beams = Json::array();
  std::array<bool, sonar_count> seen{};
  for (auto firing = firings.rbegin(); firing != firings.rend(); ++firing) {
    const SonarReading& reading = firing->reading;
    if (time_s - reading.fired_s > beam_shown_s) break;
    if (std::exchange(seen[reading.transducer], true)) continue;
    const SonarMount& mount = pioneer_3dx_sonars[reading.transducer];
    const Eigen::Vector2d apex = in_world_frame(firing->pose, {mount.x_m, mount.y_m});
    beams.push_back({apex.x(), apex.y(), firing->pose.yaw_rad + mount.heading_rad, reading.range_m,
                     static_cast<bool>(reading.echo)});
  }
  return beams;
}

/// The last steps' way: a message does not grow with the run.
Json trail_of(const std::vector<StepRecord>& steps, std::size_t most, double rate_hz) {
  Json trail = Json::array();
  const long stride = std::max(1L, std::lround(trail_step_s * rate_hz)), last = steps.back().step;
  const std::size_t shown = std::min(steps.size(), most);
  for (std::size_t k = steps.size() - shown; k < steps.size(); ++k) {
    if (steps[k].step % stride == 0 || steps[k].step == last)
      trail.push_back({steps[k].pose.x_m, steps[k].pose.y_m});
  }
  return trail;
}

}  // namespace

/// Draws what a run without pictures would have seen, on a thread of its own: the newest view alone, so that
/// neither the run nor what is said of it waits.
class ScenarioSession::Eye {
 public:
  using Draw =
      std::function<cv::Mat(std::optional<CameraRenderer>& renderer, std::shared_ptr<const World>& world)>;

  void look(Draw draw) {
    job_.ask([this, draw = std::move(draw), seen = Clock::now()] {
      std::packaged_task<cv::Mat()> task([&] { return draw(renderer_, world_); });
      task();
      const std::lock_guard lock(mutex_);
      picture_ = task.get_future();
      seen_ = seen;
    });
  }
  /// The last picture that was drawn, or why it could not be.
  cv::Mat picture() const {
    const std::lock_guard lock(mutex_);
    return picture_.valid() ? picture_.get() : cv::Mat();
  }
  Clock::time_point seen() const {  // what that picture shows
    const std::lock_guard lock(mutex_);
    return seen_;
  }

 private:
  std::optional<CameraRenderer> renderer_;  // the job's own
  std::shared_ptr<const World> world_;
  mutable std::mutex mutex_;
  std::shared_future<cv::Mat> picture_;  // is there, or failed
  Clock::time_point seen_;
  NewestJob job_;  // last: it uses all of the above
};

ScenarioSession::~ScenarioSession() = default;

ScenarioSession::ScenarioSession(Scenario scenario, ScenarioSessionOptions options, LiveExchange& exchange)
    : scenario_(std::move(scenario)), options_(std::move(options)), exchange_(exchange) {
  scenario_.duration_s = longest_run_s;
}

std::size_t ScenarioSession::trail_steps() const {
  return static_cast<std::size_t>(options_.trail_s * scenario_.control_rate_hz) + 1;
}

bool ScenarioSession::goes_on() const { return !reset_ && !ended_ && !interrupt_requested(); }

void ScenarioSession::run() {
  while (!ended_ && !interrupt_requested()) {
    reset_ = false;
    run_once();
    while (goes_on()) {  // what is shown stays as the run ended
      exchange_.wait_until(Clock::now() + LiveExchange::idle);
      obey_all(nullptr);
      show_late_picture();
    }
  }
}

void ScenarioSession::run_once() {
  touches_ = {};
  due_.clear();
  noise_ = light_ = 1;
  pace_start_ = pictured_at_ = Clock::now();
  pace_start_s_ = 0;
  picture_ = nullptr;
  world_.reset();
  eye_ = std::make_shared<Eye>();
  ++runs_;
  RunOptions options;
  options.perception = options_.perception;
  options.colors = options_.colors;
  if (options_.perception == PerceptionLevel::image) {
    options.on_picture = [this](const cv::Mat& picture, const RunRecord&, const std::vector<SonarFiring>&) {
      picture_ = [picture] { return picture; };  // another one each time
      pictured_at_ = Clock::now();
    };
  }
  options.touch = [this](const RunView& now) { return between_steps(now); };
  options.go_on = [this](double) { return goes_on(); };
  if (!options_.keep) options.remembered_steps = trail_steps();
  const RunRecord run = run_closed_loop(scenario_, options);
  touches_.steps = run.steps.empty() ? 0 : run.steps.back().step + 1;
  state_["outcome"] = outcome_name(run.summary.outcome);
  state_["outcome_text"] = run.summary.outcome_text;
  publish();
  if (options_.keep) options_.keep(run, touches_);
}

/// Shows what is, waits for the wall's clock, and hands over what clients have done.
std::vector<Touch> ScenarioSession::between_steps(const RunView& now) {
  const double time_s = now.record.steps.back().time_s;
  const auto due = [&] { return pace_start_ + duration_of((time_s - pace_start_s_) / speed_); };
  if (paused_ || step_ || Clock::now() - shown_at_ >= between_moments) show(now);
  step_ = false;
  const bool late = Clock::now() > due() + most_behind;  // this machine is slower than the wall's clock
  const double speed = speed_;
  bool waited = false;
  obey_all(&now);
  while (goes_on() && !step_ && (paused_ || Clock::now() < due())) {
    exchange_.wait_until(paused_ ? Clock::now() + LiveExchange::idle : due());
    waited |= paused_;
    obey_all(&now);
    if (paused_) show_late_picture();
  }
  if (late || waited || speed != speed_) {
    pace_start_ = Clock::now();
    pace_start_s_ = time_s;
  }
  return std::exchange(due_, {});
}

void ScenarioSession::obey_all(const RunView* now) {
  for (const LiveCommand& command : exchange_.next_commands())
    answer(command, [&] { return done(command.what, now); });
}

/// `now`: the run, while it goes on.
ScenarioSession::Json ScenarioSession::done(const Json& what, const RunView* now) {
  const std::string verb = text_at(what, "do");
  if (verb == "reset") {
    reset_ = true;
    paused_ = false;
  } else if (verb == "end") {
    ended_ = true;
  } else if (verb == "save") {
    if (now != nullptr) touches_.steps = now->record.steps.back().step + 1;
    return download_json("touches.yaml", touches_yaml(touches_));
  } else if (now == nullptr) {
    throw Refusal("the run is over: press Reset");
  } else if (verb == "touch") {
    touch(what, *now);
  } else if (verb == "pause") {
    paused_ = !paused_;
    show(*now);
  } else if (verb == "step") {
    paused_ = step_ = true;
  } else if (verb == "speed") {
    const double speed = number_at(what, "factor", 0);
    if (!(speed >= 0.05 && speed <= 4)) throw Refusal("the pace is 0.05 to 4 times the wall's");
    speed_ = speed;
  } else {
    throw Refusal(fmt::format("'{}' is nothing that can be done here", verb.substr(0, 40)));
  }
  return Json::object();
}

/// It is done once this step is over: to the scenario as those leave it that wait already.
void ScenarioSession::touch(const Json& what, const RunView& now) {
  Scenario then = now.scenario;
  for (const Touch& each : due_) touch_scenario(each, scenario_, then);
  const auto asked = what.find("touch");
  const Touch touch =
      parse_touch(asked == what.end() ? "{}" : asked->dump(), now.record.steps.back().step, scenario_, then);
  if (touch.kind == Touch::Kind::noise) noise_ = touch.value;
  if (touch.kind == Touch::Kind::light) light_ = touch.value;
  world_.reset();
  due_.push_back(touch);
  touches_.list.push_back(touch);
  if (paused_) show(now);
}

void ScenarioSession::show(const RunView& now) {
  shown_at_ = Clock::now();
  state_ = state(now);
  if (options_.perception != PerceptionLevel::image) draw_later(now);
  publish();
}

/// The newest frame; a run that needs no pictures is not held up by them.
void ScenarioSession::draw_later(const RunView& now) {
  if (now.record.frames.empty() || !exchange_.is_looked_at("picture")) return;
  if (!world_ && due_.empty()) world_ = std::make_shared<const World>(now.scenario.world);
  if (!world_) return;
  const FrameRecord& frame = now.record.frames.back();
  eye_->look([world = world_, frame, camera = now.scenario.camera, seed = scenario_.seed,
              believed = now.scenario.believed.camera(now.scenario.camera.camera),
              radius_m = now.scenario.goal().ball_radius_m](auto& renderer, auto& drawn) {
    if (drawn != world) {
      if (renderer)
        renderer->set_world(*world);
      else
        renderer.emplace(camera.camera, *world, camera.sensor);
      drawn = world;
    }
    cv::Mat picture = expose(renderer->radiance({frame.view}), camera.sensor, seed,
                             static_cast<std::uint64_t>(frame.frame));
    draw_detection(picture, believed, frame.measurement, radius_m, "");
    return picture;
  });
  picture_ = [eye = eye_] { return eye->picture(); };
}

/// A picture that came late is shown while nothing else happens.
void ScenarioSession::show_late_picture() {
  if (eye_->seen() > pictured_at_) publish();
}

void ScenarioSession::publish() {
  pictured_at_ = std::max(pictured_at_, eye_->seen());
  exchange_.publish(state_, pictured_at_, [picture = picture_](const std::string& view) {
    return view == "picture" && picture ? picture() : cv::Mat();
  });
}

ScenarioSession::Json ScenarioSession::state(const RunView& now) const {
  Scenario scenario = now.scenario;  // what waits for the next step is seen at once
  StepRecord step = now.record.steps.back();
  for (const Touch& touch : due_) {
    touch_scenario(touch, scenario_, scenario);
    if (touch.kind == Touch::Kind::robot) step.pose = touch.to;
  }
  const Room& room = scenario.world.room;
  const Footprint& body = scenario.robot.footprint;
  const Pose2 X_WO = odometry_frame(step);
  const ImageSize size = scenario.camera.camera.size();
  Json said = {{"kind", "scenario"},
               {"source", scenario.file.string()},
               {"perception", perception_level_name(options_.perception)},
               {"seed", scenario_.seed},
               {"step", step.step},
               {"time_s", step.time_s},
               {"width_px", size.width_px},
               {"height_px", size.height_px},
               {"paused", paused_},
               {"speed", speed_},
               {"message", ""},
               {"touches", touches_.list.size()},
               {"outcome", ""},
               {"outcome_text", ""},
               {"room", {room.x_min_m, room.y_min_m, room.x_max_m, room.y_max_m}},
               {"obstacles", obstacles_of(scenario.world)},
               {"balls", balls_of(scenario, step.time_s)},
               {"robot", {step.pose.x_m, step.pose.y_m, step.pose.yaw_rad}},
               {"view", view_of(scenario, step)},
               {"body_m", {body.front_m, body.rear_m, body.half_width_m}},
               {"trail", trail_of(now.record.steps, trail_steps(), scenario.control_rate_hz)},
               {"goal_m", scenario.target_distance_m},
               {"intended", points_json(foreseen_way(step.pose, step.control.intended, body))},
               {"passed", points_json(foreseen_way(step.pose, step.control.command, body))},
               {"shield", step.control.shield},
               {"state", control_state_name(step.control.state)},
               {"reason", step.control.reason},
               {"track", track_state_name(step.control.track_state)},
               {"v_mps", step.twist.v_mps},
               {"w_radps", step.twist.w_radps},
               {"range_error_m", step.range_error_m},
               {"bearing_rad", step.bearing_rad},
               {"clearance_m", step.clearance_m},
               {"beams", beams_of(now.firings, step.time_s)},
               {"beam_half_rad", scenario.robot.sonar ? scenario.robot.sonar->beam.half_angle_rad : 0.0},
               {"ellipse", nullptr},
               {"free", nullptr},
               {"law", scenario.law.name},
               {"laws", builtin_laws().names()},
               {"gain_per_s", scenario.law.gain_per_s},
               {"latency_s", scenario.camera.latency_s},
               {"noise", noise_},
               {"light", light_},
               {"avoidance", avoidance_type_name(scenario.avoidance.type)},
               {"avoidances", Json::array()}};
  for (int type = 0; type <= static_cast<int>(scenario_.avoidance.type); ++type)
    said["avoidances"].push_back(avoidance_type_name(static_cast<AvoidanceOptions::Type>(type)));
  if (const auto ball = now.controller.ball(step.time_s)) said["ellipse"] = ellipse_of(*ball, X_WO);
  const Avoidance* avoidance = now.controller.avoidance();
  if (avoidance != nullptr && exchange_.is_looked_at("picture"))
    said["free"] = free_space(avoidance->grid(), X_WO);
  return said;
}

}  // namespace ballservo
