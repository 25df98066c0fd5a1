#include "app/experiment/touches.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"
#include "servo/features/builtin_laws.hpp"

namespace ballservo {
namespace {

using Kind = Touch::Kind;

constexpr double box_m = 0.3;  // a new box's sides and height
constexpr double most_steps = 3600 * 1000;

const Names<Kind> kinds{{"ball", Kind::ball},          {"obstacle", Kind::obstacle}, {"box", Kind::box},
                        {"robot", Kind::robot},        {"law", Kind::law},           {"gain", Kind::gain},
                        {"latency", Kind::latency},    {"noise", Kind::noise},       {"light", Kind::light},
                        {"avoidance", Kind::avoidance}};

bool puts_something(Kind kind) {
  return kind == Kind::ball || kind == Kind::obstacle || kind == Kind::box || kind == Kind::robot;
}

/// The number that a touch of this kind gives, by its key.
struct Amount {
  Kind kind;
  const char* key;
  NumberRange range;
  const char* help;
};
const std::vector<Amount> amounts{
    {Kind::gain, "per_s", NumberRange::above(0, 10, "1/s"), "law.gain_per_s"},
    {Kind::latency, "latency_s", NumberRange::within(0, 2, "s"), "camera.latency_s"},
    {Kind::noise, "factor", NumberRange::within(0, 20, ""), "on the noise of camera and fit"},
    {Kind::light, "factor", NumberRange::within(0, 20, ""), "on all lights"}};

/// A touch of the scenario as it is `now`; all but `step`.
void declare(OptionVisitor& v, Touch& touch, const Scenario& untouched, const Scenario& now) {
  v.one_of("do", touch.kind, kinds, "what is done", required);
  if (puts_something(touch.kind)) {
    const Room& room = now.world.room;
    v.number("x_m", touch.to.x_m, NumberRange::within(room.x_min_m, room.x_max_m, "m"), "put there",
             required);
    v.number("y_m", touch.to.y_m, NumberRange::within(room.y_min_m, room.y_max_m, "m"), "put there",
             required);
  }
  if (touch.kind == Kind::robot)
    v.number("yaw_rad", touch.to.yaw_rad, NumberRange::within(-1e4, 1e4, "rad"), "its heading", required);
  if (touch.kind == Kind::obstacle) {
    std::vector<std::string> names;
    for (const Obstacle& each : now.world.obstacles) names.push_back(each.name);
    v.choice("name", touch.name, names, "the one that is put there", required);
  }
  if (touch.kind == Kind::law)
    v.choice("name", touch.name, builtin_laws().names(), "the law from then on", required);
  for (const Amount& amount : amounts)
    if (touch.kind == amount.kind) v.number(amount.key, touch.value, amount.range, amount.help, required);
  if (touch.kind == Kind::avoidance) {
    using Type = AvoidanceOptions::Type;
    std::vector<Type> types{Type::none, Type::shield, Type::full};
    types.resize(static_cast<std::size_t>(untouched.avoidance.type) + 1);  // no more than the run began with
    v.one_of("type", touch.avoidance, names_of(types, avoidance_type_name), "from then on", required);
  }
}

Obstacle new_box(const World& world, const Pose2& to) {
  Obstacle box;
  for (int n = 1; box.name.empty() || find_named(world.obstacles, box.name) != world.obstacles.end(); ++n)
    box.name = fmt::format("dropped_{}", n);
  box.shape = BoxShape{{box_m, box_m, box_m}};
  box.center_m = {to.x_m, to.y_m, box_m / 2};
  box.material.texture.color = {0.45, 0.36, 0.26};
  return box;
}

std::string touch_text(const Touch& touch) {
  const auto kind =
      std::find_if(kinds.begin(), kinds.end(), [&](const auto& each) { return each.second == touch.kind; });
  std::string text = fmt::format("{{step: {}, do: {}", touch.step, kind->first);
  if (puts_something(touch.kind))
    text += ", x_m: " + number_text(touch.to.x_m) + ", y_m: " + number_text(touch.to.y_m);
  if (touch.kind == Kind::robot) text += ", yaw_rad: " + number_text(touch.to.yaw_rad);
  if (!touch.name.empty()) text += ", name: " + nlohmann::json(touch.name).dump();
  for (const Amount& amount : amounts)
    if (touch.kind == amount.kind) text += fmt::format(", {}: {}", amount.key, number_text(touch.value));
  if (touch.kind == Kind::avoidance) text += fmt::format(", type: {}", avoidance_type_name(touch.avoidance));
  return text + "}";
}

}  // namespace

void touch_scenario(const Touch& touch, const Scenario& untouched, Scenario& scenario) {
  World& world = scenario.world;
  switch (touch.kind) {
    case Kind::ball: {
      Ball& ball = world.balls[scenario.target];
      ball.position_m.head<2>() = Eigen::Vector2d(touch.to.x_m, touch.to.y_m);
      ball.motion = StaticMotion{};
      break;
    }
    case Kind::obstacle:
      find_named(world.obstacles, touch.name)->center_m.head<2>() =
          Eigen::Vector2d(touch.to.x_m, touch.to.y_m);
      break;
    case Kind::box:
      world.obstacles.push_back(new_box(world, touch.to));
      break;
    case Kind::robot:
      break;
    case Kind::law:
      scenario.law.name = touch.name;
      break;
    case Kind::gain:
      scenario.law.gain_per_s = touch.value;
      break;
    case Kind::latency:
      scenario.camera.latency_s = touch.value;
      break;
    case Kind::noise:
      scenario.camera.sensor.read_noise = untouched.camera.sensor.read_noise * touch.value;
      scenario.camera.sensor.shot_noise = untouched.camera.sensor.shot_noise * touch.value * touch.value;
      scenario.geometric.center_sigma_px = untouched.geometric.center_sigma_px * touch.value;
      scenario.geometric.radius_sigma_px = untouched.geometric.radius_sigma_px * touch.value;
      break;
    case Kind::light:
      for (std::size_t k = 0; k < world.lights.size(); ++k)
        world.lights[k].intensity = untouched.world.lights[k].intensity * touch.value;
      for (std::size_t k = 0; k < world.changing_ambient.size(); ++k)
        world.changing_ambient[k].intensity = untouched.world.changing_ambient[k].intensity * touch.value;
      world.ambient = untouched.world.ambient * touch.value;
      break;
    case Kind::avoidance:
      scenario.avoidance.type = touch.avoidance;
      break;
  }
}

Touch parse_touch(const std::string& text, long step, const Scenario& untouched, const Scenario& now) {
  StrictYaml yaml = StrictYaml::from_text(text, "touch");
  OptionReader reader(yaml, yaml.root());
  Touch touch;
  touch.step = step;
  declare(reader, touch, untouched, now);
  yaml.finish();
  return touch;
}

Touches read_touches(const std::filesystem::path& file, const Scenario& scenario) {
  StrictYaml yaml = StrictYaml::from_file(file);
  OptionReader reader(yaml, yaml.root());
  OptionVisitor& v = reader;
  Touches touches;
  Scenario now = scenario;
  v.integer("steps", touches.steps, 1, most_steps, "control steps of the run", required);
  v.list("touches", [&](std::size_t) {
    Touch touch;
    const double after = touches.list.empty() ? 0 : static_cast<double>(touches.list.back().step);
    const bool ok = v.without_fault([&] {
      v.integer("step", touch.step, after, static_cast<double>(touches.steps - 1),
                "it happens after this one", required);
      declare(v, touch, scenario, now);
    });
    if (!ok) return;
    touch_scenario(touch, scenario, now);
    touches.list.push_back(touch);
  });
  yaml.finish();
  return touches;
}

std::string touches_yaml(const Touches& touches) {
  std::string text = fmt::format(
      "# What was done to a run, each after a control step: ballservo servo SCENARIO --touches THIS_FILE, "
      "with the\n"
      "# run's scenario, --set, --perception and --seed (manifest.json), does it again.\nsteps: {}\n",
      touches.steps);
  text += touches.list.empty() ? "touches: []\n" : "touches:\n";
  for (const Touch& touch : touches.list) text += "  - " + touch_text(touch) + "\n";
  return text;
}

}  // namespace ballservo
