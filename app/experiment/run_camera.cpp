#include "app/experiment/run_camera.hpp"

#include <algorithm>
#include <cmath>

#include "app/experiment/cpu_clock.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {

namespace {

std::unique_ptr<BallSight> make_sight(const Scenario& scenario, const RunOptions& options) {
  const Ball& target = scenario.target_ball();
  Ball believed_target = target;
  believed_target.diameter_m *= scenario.believed.diameter_scale;
  const Camera believed_camera = scenario.believed.camera(scenario.camera.camera);
  if (options.perception != PerceptionLevel::image) {
    GeometricSensorOptions sensor = scenario.geometric;
    sensor.exact = options.perception == PerceptionLevel::truth;
    return make_geometric_sight(
        scenario.camera.camera, target, sensor, options.seed,
        scenario.believed.see_elsewhere()
            ? std::make_optional(BelievedView{believed_camera, believed_target.radius_m()})
            : std::nullopt);
  }
  if (!options.colors) {
    throw InputError(scenario.file.string() + ": colors", "nothing",
                     "a colours file, which perception from images needs");
  }
  return make_image_sight(believed_camera, options.colors, believed_target, scenario.world.balls,
                          scenario.goal(), options.seed, scenario.fixed_colors);
}

std::unique_ptr<FloorSight> make_floor_sight(const Scenario& scenario, const RunOptions& options) {
  if (scenario.avoidance.type == AvoidanceOptions::Type::none || !scenario.avoidance.floor) return nullptr;
  if (options.perception == PerceptionLevel::image) return make_image_floor_sight(scenario);
  return make_geometric_floor_sight(scenario, options.seed, options.perception == PerceptionLevel::truth);
}

}  // namespace

RunCamera::RunCamera(const Scenario& scenario, const RunOptions& options)
    : scenario_(scenario),
      seed_(options.seed),
      image_(options.perception == PerceptionLevel::image),
      sight_(make_sight(scenario, options)),
      floor_(make_floor_sight(scenario, options)),
      faults_(scenario.camera.faults, options.seed) {
  if (image_ || options.on_picture) {
    renderer_ =
        std::make_unique<CameraRenderer>(scenario.camera.camera, scenario.world, scenario.camera.sensor);
  }
  const int steps = renderer_ ? scenario.camera.exposure_steps : 1;
  for (int i = 0; i < steps; ++i) {
    if (steps % 2 == 0 && i == steps / 2) instants_.push_back({0.5, false});
    instants_.push_back({(i + 0.5) / steps, true});
  }
}

double RunCamera::start_s() const { return static_cast<double>(frame_) / scenario_.camera.rate_hz; }

double RunCamera::next_s() const {
  return start_s() + scenario_.camera.exposure_s * instants_[next_instant_].share;
}

long RunCamera::skip_to(double time_s) {
  if (next_instant_ != 0) return 0;
  const long first = frame_;
  frame_ = std::max(first, static_cast<long>(std::ceil(time_s * scenario_.camera.rate_hz - 1e-9)));
  return frame_ - first;
}

std::optional<SeenFrame> RunCamera::expose(double time_s, const Pose2& robot, std::string& rows) {
  const CameraView view{scenario_.X_WC(robot), time_s};
  const Instant& instant = instants_[next_instant_];
  if (instant.rendered) views_.push_back(view);
  if (instant.share == 0.5) {
    middle_ = view;
    middle_robot_ = robot;
  }
  if (++next_instant_ < instants_.size()) return std::nullopt;
  std::optional<SeenFrame> frame;
  if (!faults_.drops(middle_.time_s)) frame = finish(rows);
  views_.clear();
  next_instant_ = 0;
  ++frame_;
  return frame;
}

SeenFrame RunCamera::finish(std::string& rows) {
  const CameraSettings& camera = scenario_.camera;
  SeenFrame frame;
  FrameRecord& record = frame.record;
  record.frame = static_cast<int>(frame_);
  record.time_s = middle_.time_s;
  BallTruth target = ball_truth(camera.camera, scenario_.world, middle_, scenario_.target);
  record.truth = target.outline;
  record.truth_p_CB = target.p_CB;
  record.visible_fraction = target.visible_fraction;
  const double level = faults_.level(middle_.time_s);
  if (renderer_) {
    SensorOptions sensor = camera.sensor;
    sensor.gain *= level;
    frame.picture =
        ballservo::expose(renderer_->radiance(views_), sensor, seed_, static_cast<std::uint64_t>(frame_));
  }
  const bool shows_colors = CameraFaults::shows_colors(level);
  if (!shows_colors) target.visible_fraction = 0;  // for levels without pictures

  SightInput input;
  input.frame = record.frame;
  input.time_s = record.time_s;
  if (image_) input.picture = &frame.picture;
  input.target = &target;
  const double before_s = thread_cpu_s();
  const Sight sight = sight_->look(input, rows);
  if (floor_ && (image_ || shows_colors)) {
    frame.floor = floor_->look({input.frame, input.time_s, middle_robot_, input.picture, sight.outline});
  }
  frame.perception_ms = (thread_cpu_s() - before_s) * 1e3;
  record.measurement = sight.measurement;
  record.measured = sight.outline;
  frame.arrives_s = std::max(record.time_s + camera.latency_s, start_s() + camera.exposure_s);
  return frame;
}

}  // namespace ballservo
