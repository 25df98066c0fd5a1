#include "app/experiment/peer_robot.hpp"

#include <algorithm>
#include <utility>

namespace ballservo {

PeerRobot::PeerRobot(LockstepSocket& socket, const Scenario& scenario, bool pictures)
    : socket_(socket), scenario_(scenario) {
  bounds_.until_s = -1;
  bounds_.period_s = 1 / scenario.control_rate_hz;
  if (pictures) bounds_.picture = scenario.camera.camera.size();
  advance_to(0);
}

void PeerRobot::advance_to(double time_s) {
  if (time_s <= bounds_.until_s) return;
  LockstepRequest request{time_s, command_, pan_radps_};
  if (bounds_.until_s < 0) request.scenario = nlohmann::json::parse(scenario_.resolved_json);
  bounds_.until_s = time_s;
  socket_.send(parts_of(request));
  LockstepAnswer answer = answer_of(socket_.receive(), bounds_);
  if (!answer.outcome.empty()) throw PeerGone("the peer ended the run: " + answer.text, answer.outcome);
  if (time_s == 0) has_sonars_ = answer.sonars.has_value();
  now_ = answer.state;
  truth_.reset();
  if (answer.truth) truth_ = RobotTruth{now_.time_s, answer.truth->pose, answer.truth->twist, now_.pan};
  if (answer.sonars) readings_.insert(readings_.end(), answer.sonars->begin(), answer.sonars->end());
  for (LockstepFrame& frame : answer.frames) frames_.push_back(std::move(frame));
  if (frames_.empty()) return;
  bounds_.frame = std::max(bounds_.frame, frames_.back().frame.number);
  bounds_.frame_s = std::max(bounds_.frame_s, frames_.back().frame.time_s);
}

RobotState PeerRobot::read(double now_s) {
  advance_to(now_s);
  when_read_ = truth_;
  return now_;
}

void PeerRobot::listen(const std::function<void(const SonarReading&)>& hear) {
  for (const SonarReading& reading : std::exchange(readings_, {})) hear(reading);
}

std::optional<CameraFrame> PeerRobot::take(Clock&, double until_s) {
  advance_to(until_s);
  if (frames_.empty()) return std::nullopt;
  LockstepFrame arrived = std::move(frames_.front());
  frames_.pop_front();
  ball_ = arrived.ball;
  return std::move(arrived.frame);
}

void PeerRobot::leave(const std::string& why) noexcept {
  if (std::exchange(left_, true)) return;
  try {
    socket_.send(parts_of(LockstepRequest{std::max(bounds_.until_s, 0.0), {}, 0, why}));
  } catch (const std::exception&) {  // NOLINT: nobody is left to hear of it
  }
}

Percept PeerPerception::look(const CameraFrame& frame) {
  Percept percept{robot_.ball()};
  if (percept.ball.state != TrackState::none) {
    percept.outline =
        project_sphere(scenario_.camera.camera, percept.ball.p_CB, scenario_.target_ball().radius_m());
    note(scenario_, frame, percept, 1);
  }
  stamp_as_believed(scenario_, percept);
  return percept;
}

}  // namespace ballservo
