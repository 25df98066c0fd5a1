#include "app/experiment/simulated_perception.hpp"

#include <optional>

#include "app/io/ball_rows.hpp"
#include "app/loop/image_perception.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "servo/control/ball_memory.hpp"
#include "servo/simulation/robot/geometric_sensors.hpp"

namespace ballservo {

PerceptionLevel parse_perception_level(const std::string& text) {
  for (const PerceptionLevel level :
       {PerceptionLevel::image, PerceptionLevel::geometric, PerceptionLevel::truth}) {
    if (text == perception_level_name(level)) return level;
  }
  throw InputError("--perception", text, "image, geometric or truth");
}

std::shared_ptr<const ColorTable> colors_of(const Scenario& scenario, PerceptionLevel level) {
  if (level != PerceptionLevel::image || scenario.colors.empty()) return nullptr;
  return std::make_shared<ColorTable>(read_color_file(scenario.colors));
}

namespace {
constexpr const char* source_name = "camera";
}  // namespace

SimulatedPerception::SimulatedPerception() : tracks_csv_(ball_rows_header()) {}

void SimulatedPerception::note(const Scenario& scenario, const CameraFrame& frame, const Percept& percept,
                               double quality) {
  BallObservation ball;
  if (percept.outline) ball.outline = *percept.outline;
  ball.position = BallPosition{percept.ball.p_CB, percept.ball.covariance_m2};
  ball.quality = quality;
  tracks_csv_ += ball_row({source_name, static_cast<int>(frame.number), frame.time_s, 1,
                           scenario.target_ball().class_name, track_state_name(percept.ball.state)},
                          ball);
}

void stamp_as_believed(const Scenario& scenario, Percept& percept) {
  percept.ball.time_s -= scenario.believed.latency_error_s;
  percept.floor.time_s = percept.ball.time_s;
}

namespace {

bool looks_at_floor(const Scenario& scenario) {
  return scenario.avoidance.type != AvoidanceOptions::Type::none && scenario.avoidance.floor;
}

double believed_radius_m(const Scenario& scenario) {
  return scenario.target_ball().radius_m() * scenario.believed.diameter_scale;
}

class RenderedPerception final : public SimulatedPerception {
 public:
  RenderedPerception(const Scenario& scenario, Tracker tracker, const TargetOptions& target)
      : scenario_(scenario), perception_(std::move(tracker), target, floor_detection(scenario)) {}

  Percept look(const CameraFrame& frame) override {
    Percept percept = perception_.look(frame);
    const ColorTable& colors = perception_.tracker().detector().colors();
    for (const Track& track : perception_.tracks()) {
      tracks_csv_ += ball_row({source_name, static_cast<int>(frame.number), frame.time_s, track.id,
                               colors.name_of(track.color_class), track_state_name(track.state)},
                              track.ball);
    }
    stamp_as_believed(scenario_, percept);
    return percept;
  }
  std::optional<AssumedLight> assumed_light() const override { return perception_.tracker().assumed_light(); }

 private:
  static std::optional<FloorDetection> floor_detection(const Scenario& scenario) {
    if (!looks_at_floor(scenario)) return std::nullopt;
    return FloorDetection(scenario.believed.camera(scenario.camera.camera), scenario.goal().mount,
                          scenario.avoidance.grid.start_clear_m);
  }

  const Scenario& scenario_;
  ImagePerception perception_;
};

class GeometricPerception final : public SimulatedPerception {
 public:
  GeometricPerception(const Scenario& scenario, bool exact, const SimulatedCamera& camera)
      : scenario_(scenario),
        camera_(camera),
        believed_camera_(scenario.believed.camera(scenario.camera.camera)),
        exact_(exact) {
    GeometricPerception::look_around();
  }

  void look_around() override {
    GeometricSensorOptions sensor = scenario_.geometric;
    sensor.exact = exact_;
    sensor_.emplace(scenario_.camera.camera, sensor, scenario_.seed);
    constexpr double edge_sigma_px = 1.5;
    if (floor_ || looks_at_floor(scenario_)) {
      floor_.emplace(scenario_.world, scenario_.camera.camera, scenario_.camera.mount, floor_reach_m,
                     exact_ ? 0.0 : edge_sigma_px, scenario_.target_ball().name);
    }
  }

  Percept look(const CameraFrame& frame) override {
    const ExposureTruth& truth = camera_.truth();
    const bool shows_colors = CameraFaults::shows_colors(truth.level);
    BallTruth target = truth.target;
    if (!shows_colors) target.visible_fraction = 0;
    Percept percept;
    const double diameter_m = scenario_.target_ball().diameter_m;
    percept.ball =
        sensor_->measure(target, diameter_m, frame.time_s, static_cast<std::uint64_t>(frame.number));
    if (percept.ball.state != TrackState::none) believe(percept);
    if (percept.ball.state != TrackState::none) note(scenario_, frame, percept, target.visible_fraction);
    if (floor_ && shows_colors) {
      percept.floor = floor_->scan(truth.robot, frame.time_s, scenario_.seed,
                                   static_cast<std::uint64_t>(frame.number), frame.pan_rad);
    }
    stamp_as_believed(scenario_, percept);
    return percept;
  }

 private:
  /// The ball's outline, and the place that it has by the camera and the diameter that are believed.
  void believe(Percept& percept) const {
    const Camera& camera = scenario_.camera.camera;
    const double radius_m = scenario_.target_ball().radius_m();
    percept.outline = project_sphere(camera, percept.ball.p_CB, radius_m);
    if (!scenario_.believed.see_elsewhere()) return;
    const auto outline = project_outline(camera, percept.ball.p_CB, radius_m, 32);
    const auto p_CB = sphere_from_outline(believed_camera_, outline, believed_radius_m(scenario_));
    if (p_CB) {
      percept.ball.p_CB = *p_CB;
    } else {
      percept.ball.state = TrackState::none;
    }
  }

  const Scenario& scenario_;
  const SimulatedCamera& camera_;
  Camera believed_camera_;
  bool exact_;
  std::optional<GeometricBallSensor> sensor_;
  std::optional<FloorSensor> floor_;
};

}  // namespace

std::unique_ptr<SimulatedPerception> make_image_perception(const Scenario& scenario,
                                                           std::shared_ptr<const ColorTable> colors) {
  const Ball& target = scenario.target_ball();
  if (!colors) {
    throw InputError(scenario.file.string() + ": colors", "nothing",
                     "a colours file, which perception from images needs");
  }
  const auto target_class = colors->find(target.class_name);
  if (!target_class) {
    std::string known = "one of the colours file's classes:";
    for (const ColorClass& color : colors->classes) known += " " + color.name;
    throw InputError("balls: class of " + target.name, target.class_name, known);
  }
  DetectorOptions detector;
  detector.seed = scenario.seed;
  if (scenario.camera.sensor.gamma == 1) detector.response = ResponseChoice::linear;
  detector.radii.resize(colors->classes.size());
  for (const Ball& ball : scenario.world.balls) {
    if (const auto color_class = colors->find(ball.class_name))
      detector.radii[*color_class - 1u].radius_m = ball.radius_m();
  }
  detector.radii[*target_class - 1u].radius_m = believed_radius_m(scenario);
  TrackerOptions tracker;
  tracker.fixed_colors = scenario.fixed_colors;
  tracker.seek_light_at_once = false;  // small balls are sure in the taught light only after some pictures
  const ServoGoal goal = scenario.goal();
  const TargetOptions selected{*target_class, goal.mount, goal.desired_p_RB().z(),
                               target.heights_m().second - target.position_m.z(),
                               goal.taught_center_over_radius ? TargetFilter::greatest_scale : 1.0};
  const auto rays = std::make_shared<RayTable>(scenario.believed.camera(scenario.camera.camera));
  return std::make_unique<RenderedPerception>(
      scenario, Tracker(Detector(rays, std::move(colors), detector), tracker), selected);
}

std::unique_ptr<SimulatedPerception> make_perception(const Scenario& scenario, PerceptionLevel level,
                                                     std::shared_ptr<const ColorTable> colors,
                                                     const SimulatedCamera& camera) {
  if (level == PerceptionLevel::image) return make_image_perception(scenario, std::move(colors));
  return std::make_unique<GeometricPerception>(scenario, level == PerceptionLevel::truth, camera);
}

}  // namespace ballservo
