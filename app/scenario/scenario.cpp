#include "app/scenario/scenario.hpp"

#include <algorithm>
#include <cmath>

#include "app/scenario/scenario_checks.hpp"
#include "app/scenario/scenario_robot.hpp"
#include "app/scenario/scenario_world.hpp"
#include "app/scenario/taught_target.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/random.hpp"
#include "calibration/base/strict_yaml.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

namespace {

/// A path as it stands in the file: relative to the file's folder.
std::filesystem::path beside(const std::filesystem::path& file, const std::string& text) {
  return (file.parent_path() / text).lexically_normal();
}

std::vector<std::string> apply_sets(StrictYaml& yaml, const std::vector<std::string>& sets) {
  std::vector<std::string> keys;
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos || equals == 0) {
      yaml.faults().add("--set", set, "key.path=value");
      continue;
    }
    keys.push_back(set.substr(0, equals));
    yaml.set(keys.back(), set.substr(equals + 1));
  }
  return keys;
}

/// Whether a key path is one of `keys` or lies below one.
bool is_set(const std::vector<std::string>& keys, const std::string& path) {
  return std::any_of(keys.begin(), keys.end(), [&](const std::string& key) {
    return path == key ||
           (path.size() > key.size() && path.compare(0, key.size(), key) == 0 && path[key.size()] == '.');
  });
}

/// Returns what was drawn, by key path.
std::vector<std::pair<std::string, double>> apply_vary(StrictYaml& yaml,
                                                       const std::vector<std::string>& set_keys,
                                                       std::uint64_t seed) {
  std::vector<std::pair<std::string, double>> drawn;
  YamlNode vary = yaml.root().map("vary", false);
  for (const std::string& key : vary.keys()) {
    YamlNode entry = vary.map(key);
    std::vector<double> values;
    const std::string kind = entry.has("choice") ? "choice" : "uniform";
    const std::size_t before = yaml.faults().faults().size();
    values = entry.numbers(kind, NumberRange::any(""), kind == "uniform" ? 2 : 0);
    if (kind == "uniform" && values.size() == 2 && values[0] > values[1]) {
      entry.fault(kind, "bounds in falling order", "[low, high]");
    }
    if (values.empty()) entry.fault(kind, "an empty list", "at least one number");
    if (yaml.faults().faults().size() != before || is_set(set_keys, key)) continue;
    RandomEngine engine = random_stream(seed, "vary:" + key);
    const double value = kind == "uniform"
                             ? uniform(engine, values[0], values[1])
                             : values[uniform_index(engine, static_cast<std::uint32_t>(values.size()))];
    yaml.set(key, number_text(value));
    drawn.emplace_back(key, value);
  }
  return drawn;
}

CameraMount read_mount(YamlNode camera) {
  YamlNode node = camera.map("mount");
  CameraMount mount;
  mount.forward_m = node.number("forward_m", NumberRange::within(-1, 1, "m"));
  mount.up_m = node.number("up_m", {0, 3, true, false, "m"});
  mount.pitch_down_rad = node.number("pitch_down_rad", NumberRange::within(-1.5707, 1.5707, "rad"));
  return mount;
}

SensorOptions read_sensor(YamlNode& camera) {
  SensorOptions sensor;
  sensor.blur_px = camera.number("blur_px", NumberRange::within(0, 20, "px"), 0.6);
  sensor.gain = camera.number("gain", {0, 100, true, false, ""}, 1.0);
  sensor.gamma = camera.number("gamma", NumberRange::within(1, 3, ""), 1.0);
  YamlNode noise = camera.map("noise", false);
  sensor.read_noise = noise.number("read", NumberRange::within(0, 255, "grey levels"), 0.0);
  sensor.shot_noise = noise.number("shot", NumberRange::within(0, 255, "grey levels"), 0.0);
  return sensor;
}

CameraFault read_camera_fault(YamlNode& node) {
  CameraFault fault;
  const NumberRange time = NumberRange::within(0, 3600, "s");
  fault.from_s = node.number("from_s", time, 0.0);
  fault.until_s = node.number("until_s", time, 3600.0);
  if (fault.until_s < fault.from_s) {
    node.fault("until_s", number_text(fault.until_s), "a time not before from_s (s)");
  }
  if (node.choice("type", {"dropped", "exposure"}) == "exposure") {
    fault.kind = CameraFault::Kind::exposure;
    fault.level = node.number("level", NumberRange::within(0, 10, ""));
    return fault;
  }
  fault.rate = node.number("rate", NumberRange::within(0, 1, ""), 1.0);
  fault.burst_frames = node.number("burst_frames", NumberRange::within(1, 10000, "frames"),
                                   CameraFault::shortest_burst_frames(fault.rate));
  if (fault.burst_frames < CameraFault::shortest_burst_frames(fault.rate)) {
    node.fault("burst_frames", number_text(fault.burst_frames),
               "at least rate / (1 - rate): shorter bursts can't make up that rate");
  }
  return fault;
}

/// Returns whether the camera itself (not its mount) was read without a fault.
bool read_camera_settings(StrictYaml& yaml, const std::filesystem::path& file, CameraSettings& settings,
                          bool& mount_ok) {
  YamlNode node = yaml.root().map("camera");
  const auto fault_count = [&yaml] { return yaml.faults().faults().size(); };
  std::size_t before = fault_count();
  settings.mount = read_mount(node);
  mount_ok = fault_count() == before;
  settings.rate_hz = node.number("rate_hz", {0, 1000, true, false, "Hz"}, 30.0);
  settings.latency_s = node.number("latency_s", NumberRange::within(0, 2, "s"), 0.033);
  settings.exposure_s = node.number("exposure_s", NumberRange::within(0, 1, "s"), 0.004);
  settings.exposure_steps = static_cast<int>(node.integer("exposure_steps", 1, 64, 1));
  if (settings.exposure_s * settings.rate_hz > 1) {
    node.fault("exposure_s", number_text(settings.exposure_s),
               "at most the time between frames, 1 / rate_hz (s)");
  }
  settings.sensor = read_sensor(node);
  for (YamlNode& fault : node.list("faults")) settings.faults.push_back(read_camera_fault(fault));

  before = fault_count();
  const std::string name = node.text("file");
  if (fault_count() != before) return false;
  settings.file = beside(file, name);
  try {
    settings.camera = read_camera(settings.file.string());
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults()) {
      yaml.faults().add(node.place("file") + ": " + fault.place, fault.found, fault.allowed);
    }
    return false;
  }
  return true;
}

bool read_target(StrictYaml& yaml, Scenario& scenario) {
  const std::size_t before = yaml.faults().faults().size();
  YamlNode node = yaml.root().map("target");
  const std::string ball = node.text("ball");
  if (node.has("taught")) {
    scenario.taught = beside(scenario.file, node.text("taught"));
    if (node.has("distance_m")) node.fault("distance_m", "both distance_m and taught", "one of them");
    yaml.faults().collect([&] {
      const TaughtTarget target = read_taught_target(scenario.taught);
      scenario.target_distance_m = target.distance_m;
      scenario.taught_center_over_radius = target.center_over_radius;
      if (target.ball != ball)
        node.fault("taught", "a file taught with ball " + target.ball, "one of ball " + ball);
    });
  } else {
    scenario.target_distance_m = node.number("distance_m", {0, 20, true, false, "m"});
  }
  const auto& balls = scenario.world.balls;
  const auto found = std::find_if(balls.begin(), balls.end(), [&](const Ball& b) { return b.name == ball; });
  if (found != balls.end()) {
    scenario.target = static_cast<std::size_t>(found - balls.begin());
  } else if (yaml.faults().faults().size() == before) {
    std::string names;
    for (const Ball& b : balls) names += (names.empty() ? "" : ", ") + b.name;
    node.fault("ball", ball, "the name of one of the balls: " + names);
  }
  return yaml.faults().faults().size() == before;
}

void read_control(StrictYaml& yaml, const LawCatalog& laws, Scenario& scenario) {
  YamlNode root = yaml.root();
  YamlNode law = root.map("law", false);
  scenario.law.name = law.choice("name", laws.names(), scenario.law.name);
  scenario.law.gain_per_s = law.number("gain_per_s", {0, 10, true, false, "1/s"}, scenario.law.gain_per_s);
  YamlNode control = root.map("control", false);
  scenario.control_rate_hz =
      control.number("rate_hz", {0, 1000, true, false, "Hz"}, scenario.control_rate_hz);
  YamlNode geometric = root.map("geometric", false);
  GeometricSensorOptions& options = scenario.geometric;
  options.center_sigma_px =
      geometric.number("center_sigma_px", NumberRange::within(0, 100, "px"), options.center_sigma_px);
  options.radius_sigma_px =
      geometric.number("radius_sigma_px", NumberRange::within(0, 100, "px"), options.radius_sigma_px);
}

}  // namespace

ServoGoal Scenario::goal() const {
  ServoGoal goal;
  goal.distance_m = target_distance_m;
  goal.ball_height_m = target_ball().position_m.z();
  goal.ball_radius_m = target_ball().radius_m() * believed.diameter_scale;
  goal.mount = believed.mount(camera.mount);
  goal.taught_center_over_radius = taught_center_over_radius;
  return goal;
}

Eigen::Isometry3d Scenario::X_WC(const Pose2& pose) const { return X_WR(pose) * camera.mount.X_RC(); }

Scenario load_scenario(const std::filesystem::path& file, const std::vector<std::string>& sets,
                       std::uint64_t seed, const LawCatalog& laws) {
  StrictYaml yaml = StrictYaml::from_file(file);
  const std::vector<std::string> set_keys = apply_sets(yaml, sets);

  Scenario scenario;
  scenario.document_json = yaml.resolved_json();
  scenario.drawn = apply_vary(yaml, set_keys, seed);
  scenario.file = file;
  scenario.seed = seed;
  scenario.resolved_json = yaml.resolved_json();
  YamlNode root = yaml.root();
  scenario.duration_s = root.number("duration_s", {0, 3600, true, false, "s"}, 30.0);
  const std::string colors = root.text("colors", "");
  if (!colors.empty()) scenario.colors = beside(file, colors);
  scenario.fixed_colors = root.boolean("fixed_colors", false);

  ScenarioReading reading;
  reading.camera_ok = read_camera_settings(yaml, file, scenario.camera, reading.mount_ok);
  reading.robot_ok = read_robot(yaml, scenario.robot);
  const WorldReading world = read_world(yaml, {scenario.robot.pose, scenario.duration_s, seed});
  scenario.world = world.world;
  reading.target_ok = read_target(yaml, scenario);
  read_control(yaml, laws, scenario);
  scenario.believed = read_beliefs(yaml.root(), scenario.camera.latency_s);
  scenario.avoidance = read_avoidance(yaml, scenario.robot);

  check_scenario(yaml, scenario, world, reading);
  yaml.finish();
  return scenario;
}

}  // namespace ballservo
