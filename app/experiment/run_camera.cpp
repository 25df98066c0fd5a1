#include "app/experiment/run_camera.hpp"

#include <algorithm>
#include <utility>

#include "app/experiment/cpu_clock.hpp"
#include "calibration/base/fault.hpp"

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
      image_(options.perception == PerceptionLevel::image),
      sight_(make_sight(scenario, options)),
      floor_(make_floor_sight(scenario, options)),
      camera_(scenario, options.seed, image_ || options.on_picture) {}

std::optional<SeenFrame> RunCamera::expose(double time_s, const Pose2& robot, std::string& rows) {
  auto exposed = camera_.expose(time_s, robot);
  if (!exposed) return std::nullopt;
  return look(std::move(*exposed), rows);
}

SeenFrame RunCamera::look(ExposedFrame&& exposed, std::string& rows) {
  const CameraSettings& camera = scenario_.camera;
  SeenFrame frame;
  FrameRecord& record = frame.record;
  record.frame = static_cast<int>(exposed.frame);
  record.time_s = exposed.middle.time_s;
  BallTruth target = ball_truth(camera.camera, scenario_.world, exposed.middle, scenario_.target);
  record.truth = target.outline;
  record.truth_p_CB = target.p_CB;
  record.visible_fraction = target.visible_fraction;
  frame.picture = std::move(exposed.picture);
  const bool shows_colors = CameraFaults::shows_colors(exposed.level);
  if (!shows_colors) target.visible_fraction = 0;  // for levels without pictures

  SightInput input;
  input.frame = record.frame;
  input.time_s = record.time_s;
  if (image_) input.picture = &frame.picture;
  input.target = &target;
  const double before_s = thread_cpu_s();
  const Sight sight = sight_->look(input, rows);
  if (floor_ && (image_ || shows_colors)) {
    frame.floor = floor_->look({input.frame, input.time_s, exposed.robot, input.picture, sight.outline});
  }
  frame.perception_ms = (thread_cpu_s() - before_s) * 1e3;
  record.measurement = sight.measurement;
  record.measured = sight.outline;
  frame.arrives_s = std::max(record.time_s + camera.latency_s, exposed.start_s + camera.exposure_s);
  return frame;
}

}  // namespace ballservo
