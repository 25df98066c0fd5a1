#include "app/experiment/peer_controller.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "calibration/base/system_file.hpp"

namespace ballservo {

namespace {

/// What a robot knows of itself; nothing of where it or the ball is.
nlohmann::json facts_of(const Scenario& scenario) {
  const ServoGoal goal = scenario.goal();
  const UnicycleLimits& limits = scenario.robot.limits;
  const PanLimits& pan = goal.mount.pan;
  const Eigen::Matrix4d X_RC = goal.mount.X_RC().matrix();
  nlohmann::json rows = nlohmann::json::array(), sonars;
  for (int i = 0; i < 4; ++i) rows.push_back({X_RC(i, 0), X_RC(i, 1), X_RC(i, 2), X_RC(i, 3)});
  if (scenario.robot.sonar)
    for (const SonarMount& mount : pioneer_3dx_sonars)
      sonars.push_back({mount.x_m, mount.y_m, mount.heading_rad});
  const ImageSize size = scenario.camera.camera.size();
  return {{"rate_hz", scenario.control_rate_hz},
          {"duration_s", scenario.duration_s},
          {"picture_px", {size.width_px, size.height_px}},
          {"camera_yaml", read_file_bytes(scenario.camera.file, 16u << 20)},
          {"X_RC", rows},
          {"pan_max_rad", pan.max_rad},
          {"pan_speed_max_radps", pan.speed_max_radps},
          {"pan_acceleration_max_radps2", pan.acceleration_max_radps2},
          {"latency_s", scenario.camera.latency_s + scenario.believed.latency_error_s},
          {"actuation_delay_s", scenario.robot.actuation_delay_s},
          {"v_max_mps", limits.v_max_mps},
          {"w_max_radps", limits.w_max_radps},
          {"a_max_mps2", limits.a_max_mps2},
          {"alpha_max_radps2", limits.alpha_max_radps2},
          {"ball_class", scenario.target_ball().class_name},
          {"ball_radius_m", goal.ball_radius_m},
          {"distance_m", goal.distance_m},
          {"sonars", sonars}};
}

}  // namespace

PeerController::PeerController(const ControllerOptions& options, std::unique_ptr<Law> law,
                               const Scenario& scenario, LockstepSocket& socket)
    : Controller(options, std::move(law)),
      socket_(socket),
      facts_(facts_of(scenario)),
      sonars_(scenario.robot.sonar.has_value()) {}

void PeerController::frame(const FrameEvent& event) {
  LockstepFrame frame{event.frame, event.percept.ball};
  frame.frame.arrives_s = event.arrived_s;
  frames_.push_back(std::move(frame));
  if (frames_.size() > most_frames) frames_.pop_front();
}

ControlOutput PeerController::step(double time_s, const Pose2& odometry, const Twist2& odometry_twist) {
  if (!request_) request_ = request_of(socket_.receive());
  if (!(std::abs(request_->until_s - time_s) < 1e-6))
    throw PeerGone(to_text({"until_s", fmt::format("{:.9g}", request_->until_s),
                            fmt::format("{:.9g}: a step is {:.9g} s", time_s, 1 / options().rate_hz)}));
  LockstepAnswer answer;
  answer.state = {time_s, odometry, odometry_twist, pan()};
  if (sonars_) answer.sonars = std::exchange(readings_, {});
  while (!frames_.empty() && frames_.front().frame.arrives_s <= time_s) {
    answer.frames.push_back(std::move(frames_.front()));
    frames_.pop_front();
  }
  answer.robot = std::exchange(facts_, nullptr);
  socket_.send(parts_of(answer));
  request_ = request_of(socket_.receive());
  ControlOutput output;
  output.command = output.intended = request_->command;
  output.pan_radps = request_->pan_radps;
  output.state = ControlState::approach;
  output.reason = "as the peer says";
  if (!answer.frames.empty()) last_seen_ = answer.frames.back().ball.state;
  output.track_state = last_seen_;
  return output;
}

void PeerController::throw_if_gone() const {
  if (request_ && !request_->end.empty())
    throw PeerGone("the controller left: " + request_->end, "interrupted");
}

void PeerController::leave(const RunSummary& summary) {
  LockstepAnswer answer;
  answer.outcome = outcome_name(summary.outcome);
  answer.text = summary.outcome_text;
  socket_.send(parts_of(answer));
}

}  // namespace ballservo
