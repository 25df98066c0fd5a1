#include "app/experiment/simulated_camera.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

SimulatedCamera::SimulatedCamera(const Scenario& scenario, std::uint64_t seed, bool with_pictures)
    : scenario_(scenario), seed_(seed), faults_(scenario.camera.faults, seed) {
  if (with_pictures) {
    renderer_ =
        std::make_unique<CameraRenderer>(scenario.camera.camera, scenario.world, scenario.camera.sensor);
  }
  const int steps = renderer_ ? scenario.camera.exposure_steps : 1;
  for (int i = 0; i < steps; ++i) {
    if (steps % 2 == 0 && i == steps / 2) instants_.push_back({0.5, false});
    instants_.push_back({(i + 0.5) / steps, true});
  }
}

double SimulatedCamera::start_s() const { return static_cast<double>(frame_) / scenario_.camera.rate_hz; }

double SimulatedCamera::next_s() const {
  return start_s() + scenario_.camera.exposure_s * instants_[next_instant_].share;
}

long SimulatedCamera::skip_to(double time_s) {
  if (next_instant_ != 0) return 0;
  const long first = frame_;
  frame_ = std::max(first, static_cast<long>(std::ceil(time_s * scenario_.camera.rate_hz - 1e-9)));
  return frame_ - first;
}

std::optional<ExposedFrame> SimulatedCamera::expose(double time_s, const Pose2& robot) {
  const CameraView view{scenario_.X_WC(robot), time_s};
  const Instant& instant = instants_[next_instant_];
  if (instant.rendered) views_.push_back(view);
  if (instant.share == 0.5) {
    middle_ = view;
    middle_robot_ = robot;
  }
  if (++next_instant_ < instants_.size()) return std::nullopt;
  std::optional<ExposedFrame> exposed;
  if (!faults_.drops(middle_.time_s)) {
    exposed = {frame_, start_s(), middle_, middle_robot_, faults_.level(middle_.time_s), {}};
    if (renderer_) {
      SensorOptions sensor = scenario_.camera.sensor;
      sensor.gain *= exposed->level;
      exposed->picture =
          ballservo::expose(renderer_->radiance(views_), sensor, seed_, static_cast<std::uint64_t>(frame_));
    }
  }
  views_.clear();
  next_instant_ = 0;
  ++frame_;
  return exposed;
}

}  // namespace ballservo
