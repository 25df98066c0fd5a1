#include "app/scenario/scenario.hpp"

#include <algorithm>

#include "app/scenario/scenario_checks.hpp"
#include "app/scenario/taught_target.hpp"
#include "app/scenario/world_options.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"
#include "calibration/base/random.hpp"
#include "calibration/camera/files/camera_file.hpp"

namespace ballservo {

namespace {

std::vector<std::string> apply_sets(StrictYaml& yaml, const std::vector<std::string>& sets) {
  std::vector<std::string> keys;
  for (const std::string& set : sets) {
    const std::size_t equals = set.find('=');
    const bool has_value =
        equals != std::string::npos && set.find_first_not_of(" \t", equals + 1) != std::string::npos;
    if (!has_value || equals == 0) {
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
  const std::string of_path = with_dots(path) + ".";
  return std::any_of(keys.begin(), keys.end(), [&](const std::string& key) {
    const std::string of_key = with_dots(key) + ".";
    return of_path.compare(0, of_key.size(), of_key) == 0;
  });
}

/// An entry of `vary`.
struct VariedKey {
  std::string key;
  bool choice = false;  ///< one of `values`; else a number between the two
  std::vector<double> values;
};

void declare(OptionVisitor& v, VariedKey& varied) {
  const auto values = [&v, &varied](const std::string& kind, std::size_t count, const std::string& help) {
    v.only_if((kind == "choice") == varied.choice, kind, [&] {
      v.numbers(kind, varied.values, NumberRange::any(""), count, help, required);
      v.require(!varied.values.empty(), kind, "an empty list", "at least one number");
    });
  };
  varied.choice = v.present("choice", varied.choice);
  values("choice", 0, "one of these");
  values("uniform", 2, "a number between these two");
  v.require(varied.choice || varied.values.size() != 2 || varied.values[0] <= varied.values[1], "uniform",
            "bounds in falling order", "[low, high]");
}

/// What is wrong with an entry is said, and the entry left out.
void declare_vary(OptionVisitor& v, std::vector<VariedKey>& all) {
  v.entries("vary", "KEY.PATH", [&](const std::string& key) {
    const auto is_same = [&](const VariedKey& other) { return with_dots(other.key) == with_dots(key); };
    v.require(std::none_of(all.begin(), all.end(), is_same), key, "an entry above too", "each key once");
    VariedKey varied{key, false, {}};
    if (v.without_fault([&] { v.map(key, required, [&] { declare(v, varied); }); })) all.push_back(varied);
  });
}

/// Returns what was drawn, by key path.
std::vector<std::pair<std::string, double>> apply_vary(StrictYaml& yaml,
                                                       const std::vector<std::string>& set_keys,
                                                       std::uint64_t seed) {
  OptionReader reader(yaml, yaml.root());
  std::vector<VariedKey> all;
  declare_vary(reader, all);
  std::vector<std::pair<std::string, double>> drawn;
  for (const auto& [key, choice, values] : all) {
    if (is_set(set_keys, key)) continue;
    RandomEngine engine = random_stream(seed, "vary:" + key);
    const double value = choice ? values[uniform_index(engine, static_cast<std::uint32_t>(values.size()))]
                                : uniform(engine, values[0], values[1]);
    yaml.set(key, number_text(value));
    drawn.emplace_back(key, value);
  }
  return drawn;
}

/// The faults with those of drawn values at the entries of `vary`; else they would be --set's, which have no
/// line either. At a line of the file it is said what was set or drawn below it.
std::vector<Fault> with_origins(std::vector<Fault> faults, const StrictYaml& yaml,
                                const std::vector<std::string>& sets,
                                const std::vector<std::pair<std::string, double>>& drawn) {
  static const std::string of_set = "--set";
  for (Fault& fault : faults) {
    const bool of_file = fault.place.compare(0, of_set.size(), of_set) != 0;
    const std::string path = fault.place.substr(fault.place.rfind(' ') + 1);
    std::string origins;
    for (auto set = sets.begin(); set != sets.end(); ++set) {
      const auto key_of = [](const std::string& text) { return text.substr(0, text.find('=')); };
      const auto overrules = [&](const std::string& later) { return is_set({key_of(later)}, key_of(*set)); };
      if (of_file && is_set({path}, key_of(*set)) && std::none_of(set + 1, sets.end(), overrules))
        origins += ", " + *set + " set";
    }
    for (const auto& [key, value] : drawn) {
      if (!is_set({path}, key)) continue;
      if (!of_file) fault.place = yaml.root().map("vary").place(key);
      if (of_file)
        origins += ", " + key + "=" + number_text(value) + " drawn";
      else if (fault.found == number_text(value))
        origins = ", drawn";
    }
    if (!origins.empty()) fault.found += " (" + origins.substr(2) + ")";
  }
  return faults;
}

/// A scenario as it is being read: what its keys name, and which parts were read without a fault.
struct Draft {
  Scenario& scenario;
  const LawCatalog& laws;
  std::vector<std::string> set_keys{};
  WorldOptions world{};
  std::string camera_file{}, colors{}, target_ball{}, taught{};
  ScenarioReading ok{};
};

void declare_camera(OptionVisitor& v, Draft& draft) {
  CameraSettings& camera = draft.scenario.camera;
  draft.ok.mount_ok = v.without_fault([&] { v.part("mount", camera.mount, required); });
  v.number("rate_hz", camera.rate_hz, NumberRange::above(0, 1000, "Hz"), "frames");
  v.number("latency_s", camera.latency_s, NumberRange::within(0, 2, "s"),
           "from the middle of an exposure to its measurement");
  v.number("exposure_s", camera.exposure_s, NumberRange::within(0, 1, "s"), "of a frame");
  v.integer("exposure_steps", camera.exposure_steps, 1, 64,
            "moments of an exposure that are averaged; 1: no motion blur");
  v.require(camera.exposure_s * camera.rate_hz <= 1, "exposure_s", number_text(camera.exposure_s),
            "at most the time between frames, 1 / rate_hz (s)");
  declare(v, camera.sensor);
  v.number("white_balance_k", camera.white_balance_k,
           NumberRange::within(min_temperature_k, max_temperature_k, "K"), "colour temperature of white");
  v.list("faults", [&](std::size_t) { declare(v, camera.faults.emplace_back()); });
  draft.ok.camera_ok =
      v.without_fault([&] { v.text("file", draft.camera_file, "its calibration", required); });
}

void declare_pose(OptionVisitor& v, Pose2& pose) {
  const NumberRange place_m = NumberRange::within(-100, 100, "m");
  v.number("x_m", pose.x_m, place_m, "of the axle's middle at 0 s");
  v.number("y_m", pose.y_m, place_m, "of the axle's middle at 0 s");
  v.number("yaw_rad", pose.yaw_rad, NumberRange::within(-6.2832, 6.2832, "rad"),
           "counter-clockwise from the x axis, at 0 s");
}

/// A fault of one transducer or of an array of eight.
void declare_sonar_fault(OptionVisitor& v, std::vector<SonarFault>& faults) {
  using FaultKind = SonarFault::Kind;
  SonarFault fault;
  v.one_of("type", fault.kind,
           {{"dead", FaultKind::dead},
            {"stuck", FaultKind::stuck},
            {"long", FaultKind::reads_long},
            {"late", FaultKind::late}},
           "silent, repeating its first answer, reading too long, answering late", required);
  v.number("from_s", fault.from_s, NumberRange::within(0, 3600, "s"), "the fault begins");
  v.only_if(fault.kind == FaultKind::reads_long, "type: long", [&] {
    v.number("by_m", fault.amount, NumberRange::above(0, 5, "m"), "added to every range", required);
  });
  v.only_if(fault.kind == FaultKind::late, "type: late", [&] {
    v.number("by_s", fault.amount, NumberRange::above(0, 10, "s"), "every answer's delay", required);
  });
  std::optional<std::string> array;
  v.maybe("array", array, [&](const std::string& key, std::string& name) {
    v.choice(key, name, {"front", "rear"}, "all eight of an array, instead of `sonar`", otherwise("none"));
  });
  v.require(!array || !v.present("sonar", false), "array", "both sonar and array", "one of them");
  v.only_if(!array, "no array",
            [&] { v.integer("sonar", fault.transducer, 0, sonar_count - 1, "the transducer", required); });
  const std::size_t first = array ? (*array == "rear" ? 8 : 0) : fault.transducer;
  for (std::size_t k = 0; k < (array ? 8 : 1); ++k) {
    fault.transducer = first + k;
    faults.push_back(fault);
  }
}

void declare_robot(OptionVisitor& v, RobotSettings& robot) {
  std::string type = "pioneer_3dx";
  v.choice("type", type, {"pioneer_3dx"}, "its body, drive and sonars");
  v.map("pose", [&] { declare_pose(v, robot.pose); });
  v.number("actuation_delay_s", robot.actuation_delay_s, NumberRange::within(0, 2, "s"),
           "from a command until it moves the robot");
  v.part("limits", robot.limits);
  v.number("acceleration_share", robot.acceleration_share, NumberRange::within(0.01, 10, ""),
           "the drive's true accelerations over those of `limits`");
  v.part("odometry", robot.odometry);
  v.maybe("sonar", robot.sonar, [&](const std::string& key, SonarOptions& sonar) { v.part(key, sonar); });
  v.list("faults", [&](std::size_t) { declare_sonar_fault(v, robot.sonar_faults); });
  v.require(robot.sonar_faults.empty() || robot.sonar, "faults", "faults of sonars that the robot has not",
            "robot.sonar beside it");
}

/// For a robot that is known: `full` for one with sonars, `none` for one without, unless said otherwise.
void declare_avoidance(OptionVisitor& v, AvoidanceOptions& avoidance, const RobotSettings& robot) {
  using Type = AvoidanceOptions::Type;
  const std::vector<Type> types{Type::none, Type::shield, Type::full};
  avoidance.type = robot.sonar ? Type::full : Type::none;
  v.one_of("type", avoidance.type, names_of(types, avoidance_type_name),
           "the law alone, stopping before obstacles, driving around them",
           otherwise("full with sonars, else none"));
  v.require(avoidance.type == Type::none || robot.sonar, "type",
            std::string(avoidance_type_name(avoidance.type)) + ", for a robot without sonars",
            "none, or robot.sonar beside it");
  declare(v, avoidance);
  OccupancyGridOptions& grid = avoidance.grid;
  grid.footprint = robot.footprint;
  grid.odometry = robot.odometry.bound;
  if (robot.sonar) {
    grid.beam = robot.sonar->beam;
    grid.range_error_m = robot.sonar->noise_bound_m() + 0.01;
  }
}

void declare_target(OptionVisitor& v, Draft& draft) {
  v.text("ball", draft.target_ball, "its name among the balls", required);
  const bool taught = v.present("taught", false);
  v.require(!taught || !v.present("distance_m", false), "distance_m", "both distance_m and taught",
            "one of them");
  v.only_if(taught, "no distance_m", [&] {
    v.text("taught", draft.taught, "file of `servo --teach`, instead of `distance_m`", otherwise("none"));
  });
  v.only_if(!taught, "no taught", [&] {
    v.number("distance_m", draft.scenario.target_distance_m, NumberRange::above(0, 20, "m"),
             "from the axle to the ball's centre, where the robot stops", required);
  });
}

void declare(OptionVisitor& v, Draft& draft) {
  Scenario& scenario = draft.scenario;
  v.number("duration_s", scenario.duration_s, NumberRange::above(0, 3600, "s"), "of the run");
  v.text("colors", draft.colors, "file of colours, which perception from pictures needs", otherwise("none"));
  v.boolean("fixed_colors", scenario.fixed_colors, "true: colours as taught, whatever the light does");
  v.map("camera", required, [&] { declare_camera(v, draft); });
  draft.ok.robot_ok =
      v.without_fault([&] { v.map("robot", required, [&] { declare_robot(v, scenario.robot); }); });
  declare(v, draft.world, scenario.camera.white_balance_k, scenario.duration_s);
  draft.ok.target_ok = v.without_fault([&] { v.map("target", required, [&] { declare_target(v, draft); }); });
  v.map("law", [&] { declare(v, scenario.law, draft.laws.names()); });
  v.map("control", [&] {
    v.number("rate_hz", scenario.control_rate_hz, NumberRange::above(0, 1000, "Hz"), "control steps");
  });
  v.part("geometric", scenario.geometric);
  v.map("believed", [&] { declare(v, scenario.believed, scenario.camera.latency_s); });
  v.map("avoidance", [&] { declare_avoidance(v, scenario.avoidance, scenario.robot); });
}

constexpr const char* where_paths_begin =
    "; a path of --set begins in the folder that you are in, one of a scenario in the scenario's folder";

/// The file that the text of a key names.
std::filesystem::path path_of(const Draft& draft, const std::string& key, const std::string& text) {
  const std::filesystem::path folder = is_set(draft.set_keys, key) ? "" : draft.scenario.file.parent_path();
  return (folder / text).lexically_normal();
}

/// Whether a file that a scenario names can be read. Its faults are its own, behind the key that names it.
template <class Read>
bool read_named(StrictYaml& yaml, const std::string& map, const std::string& key, const Read& read) {
  try {
    read();
    return true;
  } catch (const InputError& error) {
    const std::string place = yaml.root().map(map).place(key);
    for (const Fault& fault : error.faults())
      yaml.faults().add(place + ": " + fault.place, fault.found, fault.allowed + where_paths_begin);
    return false;
  }
}

void read_camera_file(StrictYaml& yaml, Draft& draft) {
  CameraSettings& camera = draft.scenario.camera;
  if (draft.camera_file.empty()) {
    yaml.root().map("camera").fault("file", "an empty name", "the file of a camera");
    draft.ok.camera_ok = false;
    return;
  }
  camera.file = path_of(draft, "camera.file", draft.camera_file);
  draft.ok.camera_ok =
      read_named(yaml, "camera", "file", [&] { camera.camera = read_camera(camera.file.string()); });
}

void read_taught(StrictYaml& yaml, Draft& draft) {
  Scenario& scenario = draft.scenario;
  scenario.taught = path_of(draft, "target.taught", draft.taught);
  read_named(yaml, "target", "taught", [&] {
    const TaughtTarget target = read_taught_target(scenario.taught);
    scenario.target_distance_m = target.distance_m;
    scenario.taught_center_over_radius = target.center_over_radius;
    if (target.ball != draft.target_ball)
      yaml.root().map("target").fault("taught", "a file taught with ball " + target.ball,
                                      "one of ball " + draft.target_ball);
  });
}

/// A file of another kind is one fault, not one for each of its keys.
void refuse_other_kinds(const std::vector<std::string>& keys, const std::filesystem::path& file,
                        const LawCatalog& laws) {
  for (const OptionRow& row : scenario_keys(laws))
    if (std::find(keys.begin(), keys.end(), row.path.substr(0, row.path.find_first_of(".["))) != keys.end())
      return;
  throw InputError(
      file.string(), "no scenario",
      "a YAML file with camera, robot, balls and target (`ballservo servo --keys` lists all keys)");
}

void find_target(StrictYaml& yaml, Draft& draft) {
  const std::size_t before = yaml.faults().faults().size();
  if (!draft.taught.empty()) read_taught(yaml, draft);
  const auto& balls = draft.scenario.world.balls;
  const auto found = std::find_if(balls.begin(), balls.end(),
                                  [&](const Ball& ball) { return ball.name == draft.target_ball; });
  draft.ok.target_ok &= yaml.faults().faults().size() == before;
  if (found != balls.end()) {
    draft.scenario.target = static_cast<std::size_t>(found - balls.begin());
  } else if (draft.ok.target_ok) {
    std::string names;
    for (const Ball& ball : balls) names += (names.empty() ? "" : ", ") + ball.name;
    yaml.root().map("target").fault("ball", draft.target_ball, "the name of one of the balls: " + names);
    draft.ok.target_ok = false;
  }
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

Eigen::Isometry3d Scenario::X_WC(const Pose2& pose, double pan_rad) const {
  return X_WR(pose) * camera.mount.X_RC(pan_rad);
}

Scenario load_scenario(const std::filesystem::path& file, const std::vector<std::string>& sets,
                       std::uint64_t seed, const LawCatalog& laws) {
  StrictYaml yaml = StrictYaml::from_file(file);
  const std::vector<std::string> keys = yaml.root().keys();
  const std::vector<std::string> set_keys = apply_sets(yaml, sets);

  Scenario scenario;
  scenario.document_json = yaml.resolved_json();
  scenario.drawn = apply_vary(yaml, set_keys, seed);
  scenario.file = file;
  scenario.seed = seed;
  scenario.resolved_json = yaml.resolved_json();

  Draft draft{scenario, laws, set_keys};
  OptionReader reader(yaml, yaml.root());
  declare(reader, draft);
  if (!draft.colors.empty()) scenario.colors = path_of(draft, "colors", draft.colors);
  if (draft.ok.camera_ok) read_camera_file(yaml, draft);
  draw_world(draft.world, scenario.robot.pose, scenario.duration_s, seed);
  scenario.world = draft.world.world;
  find_target(yaml, draft);

  check_scenario(yaml, scenario, draft.world, draft.ok);
  try {
    yaml.finish();
  } catch (const InputError& error) {
    refuse_other_kinds(keys, file, laws);
    throw InputError(with_origins(error.faults(), yaml, sets, scenario.drawn));
  }
  return scenario;
}

std::vector<OptionRow> scenario_keys(const LawCatalog& laws) {
  Scenario scenario;
  Draft draft{scenario, laws};
  std::vector<VariedKey> varied;
  OptionLister lister;
  declare(lister, draft);
  declare_vary(lister, varied);
  return lister.rows();
}

}  // namespace ballservo
