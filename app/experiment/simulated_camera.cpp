#include "app/experiment/simulated_camera.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ballservo {

SimulatedCamera::SimulatedCamera(const Scenario& scenario, bool with_pictures, RobotAt robot,
                                 TakePicture take_picture)
    : scenario_(scenario), robot_(std::move(robot)), faults_(scenario.camera.faults, scenario.seed) {
  if (with_pictures && take_picture) {
    take_picture_ = std::move(take_picture);
  } else if (with_pictures) {
    renderer_ =
        std::make_unique<CameraRenderer>(scenario.camera.camera, scenario.world, scenario.camera.sensor);
  }
  const int steps = renderer_ ? scenario.camera.exposure_steps : 1;
  for (int i = 0; i < steps; ++i) {
    if (steps % 2 == 0 && i == steps / 2) instants_.push_back({0.5, false});
    instants_.push_back({(i + 0.5) / steps, true});
  }
}

std::optional<CameraFrame> SimulatedCamera::take(Clock& clock, double until_s) {
  skip_to(clock.now_s() - 0.5 / scenario_.camera.rate_hz);
  const auto next_s = [this] {
    return next_start_s() + scenario_.camera.exposure_s * instants_[next_instant_].share;
  };
  while (next_s() <= until_s) {
    clock.sleep_until(next_s());
    if (auto frame = expose(robot_(clock.now_s()))) return frame;
  }
  return std::nullopt;
}

/// Leaves out the frames that should have begun before that time, the one under way apart.
void SimulatedCamera::skip_to(double time_s) {
  if (next_instant_ != 0) return;
  const long due = static_cast<long>(std::ceil(time_s * scenario_.camera.rate_hz - 1e-9));
  skipped_ += std::max(0L, due - frame_);
  frame_ = std::max(frame_, due);
}

/// Takes an instant of the exposure. The frame, where this was its last one and it was not dropped.
std::optional<CameraFrame> SimulatedCamera::expose(const RobotTruth& robot) {
  const CameraSettings& camera = scenario_.camera;
  const CameraView view{scenario_.X_WC(robot.pose, robot.pan.angle_rad), robot.time_s};
  const Instant& instant = instants_[next_instant_];
  if (instant.rendered) views_.push_back(view);
  if (instant.share == 0.5) truth_ = {view, robot.pose, robot.pan.angle_rad, {}, faults_.level(view.time_s)};
  if (++next_instant_ < instants_.size()) return std::nullopt;

  CameraFrame frame{frame_, truth_.view.time_s,
                    std::max(truth_.view.time_s + camera.latency_s, next_start_s() + camera.exposure_s)};
  frame.pan_rad = truth_.pan_rad;
  const bool dropped = faults_.drops(frame.time_s);
  if (!dropped) {
    truth_.target = ball_truth(camera.camera, scenario_.world, truth_.view, scenario_.target);
    if (take_picture_) frame.bgr = take_picture_(truth_.view);
    if (renderer_) {
      SensorOptions sensor = camera.sensor;
      sensor.gain *= truth_.level;
      render_light();
      frame.bgr = ballservo::expose(light_, sensor, scenario_.seed, static_cast<std::uint64_t>(frame_));
    }
  }
  views_.clear();
  next_instant_ = 0;
  ++frame_;
  return dropped ? std::nullopt : std::make_optional(std::move(frame));
}

/// The light on the sensor: that of the frame before where nothing has moved or changed since.
void SimulatedCamera::render_light() {
  const auto alike = [this](const CameraView& a, const CameraView& b) {
    return a.X_WC.matrix() == b.X_WC.matrix() && looks_alike(scenario_.world, a.time_s, b.time_s);
  };
  if (std::equal(views_.begin(), views_.end(), lit_views_.begin(), lit_views_.end(), alike)) return;
  light_ = renderer_->radiance(views_);
  lit_views_ = views_;
}

}  // namespace ballservo
