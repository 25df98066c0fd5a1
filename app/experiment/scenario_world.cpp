#include "app/experiment/scenario_world.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "app/experiment/scenario_scatter.hpp"
#include "calibration/files/numbers.hpp"

namespace ballservo {

namespace {

const NumberRange place_m = NumberRange::within(-100, 100, "m");
const NumberRange share = NumberRange::within(0, 1, "");
const NumberRange temperature_k = NumberRange::within(min_temperature_k, max_temperature_k, "K");

const std::vector<std::string> obstacle_types{"box", "cylinder", "disc", "scatter"};

NumberRange size_m(double high) { return {0, high, true, false, "m"}; }

/// A colour by its word (`color: red`) or its reflectances (`rgb: [0.7, 0.05, 0.03]`); the fallback where
/// there is neither.
Rgb read_color(YamlNode& node, const std::string& suffix, const Rgb& fallback) {
  const std::string word_key = "color" + suffix, rgb_key = "rgb" + suffix;
  static const std::vector<std::string> words{"red",    "orange", "yellow", "green", "cyan", "blue",
                                              "purple", "pink",   "white",  "black", "grey", "brown"};
  if (node.has(word_key)) {
    if (node.has(rgb_key)) node.fault(rgb_key, "both " + word_key + " and " + rgb_key, "one of them");
    return *color_from_word(node.choice(word_key, words));
  }
  const std::vector<double> rgb =
      node.numbers(rgb_key, share, 3, std::vector<double>{fallback.x(), fallback.y(), fallback.z()});
  return {rgb[0], rgb[1], rgb[2]};
}

Material read_material(YamlNode& node, const Material& fallback) {
  Material material = fallback;
  std::vector<std::string> patterns;
  for (const Pattern pattern : all_patterns) patterns.emplace_back(pattern_name(pattern));
  const std::string name =
      node.choice("pattern", patterns, std::string(pattern_name(fallback.texture.pattern)));
  for (const Pattern pattern : all_patterns) {
    if (pattern_name(pattern) == name) material.texture.pattern = pattern;
  }
  material.texture.color = read_color(node, "", fallback.texture.color);
  material.texture.color_2 = read_color(node, "_2", fallback.texture.color_2);
  material.texture.scale_m = node.number("scale_m", {0.01, 10, false, false, "m"}, fallback.texture.scale_m);
  material.specular = node.number("specular", share, fallback.specular);
  material.shininess = node.number("shininess", NumberRange::within(1, 1000, ""), fallback.shininess);
  return material;
}

Room read_room(YamlNode root) {
  Room room;
  room.floor.texture = {Pattern::wood, {0.52, 0.36, 0.21}, {0.30, 0.18, 0.09}, 0.12};
  room.wall.texture = {Pattern::noise, {0.66, 0.65, 0.60}, {0.58, 0.57, 0.53}, 0.6};
  room.ceiling.texture.color = {0.80, 0.80, 0.78};
  YamlNode node = root.map("room", false);
  room.x_min_m = node.number("x_min_m", place_m, room.x_min_m);
  room.x_max_m = node.number("x_max_m", place_m, room.x_max_m);
  room.y_min_m = node.number("y_min_m", place_m, room.y_min_m);
  room.y_max_m = node.number("y_max_m", place_m, room.y_max_m);
  room.height_m = node.number("height_m", NumberRange::within(0.5, 20, "m"), room.height_m);
  if (room.x_max_m - room.x_min_m < 1)
    node.fault("x_max_m", "no room to x_min_m", "at least 1 m more than x_min_m");
  if (room.y_max_m - room.y_min_m < 1)
    node.fault("y_max_m", "no room to y_min_m", "at least 1 m more than y_min_m");
  const auto surface = [&node](const char* key, Material& material) {
    YamlNode child = node.map(key, false);
    material = read_material(child, material);
  };
  surface("floor", room.floor);
  surface("walls", room.wall);
  surface("ceiling", room.ceiling);
  return room;
}

WaypointMotion read_waypoints(YamlNode& node, const Eigen::Vector3d& start_m) {
  WaypointMotion motion;
  motion.points.push_back({0, start_m});
  for (YamlNode& item : node.list("points", true)) {
    const double time_s = item.number("time_s", {0, 3600, true, false, "s"});
    if (time_s <= motion.points.back().time_s) {
      item.fault("time_s", number_text(time_s), "a time after the point before (the start is at 0 s)");
    }
    motion.points.push_back({time_s,
                             {item.number("x_m", place_m), item.number("y_m", place_m),
                              item.number("z_m", place_m, start_m.z())}});
  }
  return motion;
}

RollingMotion read_rolling(YamlNode& node, const Room& room, double radius_m) {
  RollingMotion motion;
  const double speed_mps = node.number("speed_mps", NumberRange::within(0, 10, "m/s"));
  const double heading_rad = node.number("heading_rad", NumberRange::within(-6.2832, 6.2832, "rad"));
  motion.velocity_mps = speed_mps * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
  motion.start_s = node.number("start_s", NumberRange::within(0, 3600, "s"), 0.0);
  motion.friction_mps2 = node.number("friction_mps2", NumberRange::within(0, 10, "m/s^2"), 0.0);
  motion.restitution = node.number("restitution", share, 1.0);
  const double margin_m = radius_m + 1e-6;  // so that rounding never puts it into the wall
  motion.low_m = Eigen::Vector2d(room.x_min_m, room.y_min_m).array() + margin_m;
  motion.high_m = Eigen::Vector2d(room.x_max_m, room.y_max_m).array() - margin_m;
  return motion;
}

Motion read_motion(YamlNode& ball, const Eigen::Vector3d& start_m, const Room& room, double radius_m) {
  YamlNode node = ball.map("motion", false);
  const std::string type =
      node.choice("type", {"static", "linear", "circle", "waypoints", "rolling"}, "static");
  if (type == "rolling") return read_rolling(node, room, radius_m);
  if (type == "waypoints") return read_waypoints(node, start_m);
  if (type == "linear") {
    LinearMotion motion;
    YamlNode velocity = node.map("velocity");
    motion.velocity_mps = {velocity.number("x_mps", NumberRange::within(-10, 10, "m/s")),
                           velocity.number("y_mps", NumberRange::within(-10, 10, "m/s"))};
    motion.start_s = node.number("start_s", NumberRange::within(0, 3600, "s"), 0.0);
    motion.duration_s = node.number("duration_s", NumberRange::within(0, 3600, "s"), 3600.0);
    return motion;
  }
  if (type == "circle") {
    CircleMotion motion;
    YamlNode center = node.map("center");
    motion.center_m = {center.number("x_m", place_m), center.number("y_m", place_m)};
    motion.rate_radps = node.number("rate_radps", NumberRange::within(-10, 10, "rad/s"));
    return motion;
  }
  return StaticMotion{};
}

bool is_class_name(const std::string& text) {
  return !text.empty() && text.size() <= 64 && text[0] >= 'a' && text[0] <= 'z' &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; });
}

Ball read_ball(YamlNode& node, const Room& room) {
  Ball ball;
  ball.name = node.text("name");
  if (ball.name.empty() && node.has("name")) node.fault("name", "nothing", "a name");
  ball.class_name = node.text("class");
  if (node.has("class") && !is_class_name(ball.class_name)) {
    node.fault("class", ball.class_name, "1 to 64 of a-z, 0-9 and _, beginning with a letter");
  }
  ball.diameter_m = node.number("diameter_m", size_m(2));
  YamlNode position = node.map("position");
  ball.position_m = {position.number("x_m", place_m), position.number("y_m", place_m),
                     position.number("z_m", place_m, ball.diameter_m / 2)};
  ball.motion = read_motion(node, ball.position_m, room, ball.radius_m());
  ball.sonar = node.boolean("sonar", false);
  Material painted;
  painted.specular = 0.30;
  painted.shininess = 40;
  const auto by_class = color_from_word(ball.class_name);
  painted.texture.color = by_class.value_or(Rgb(0.5, 0.5, 0.5));
  ball.material = painted;
  ball.material.texture.color = read_color(node, "", painted.texture.color);
  ball.material.specular = node.number("specular", share, painted.specular);
  ball.material.shininess = node.number("shininess", NumberRange::within(1, 1000, ""), painted.shininess);
  if (!by_class && !node.has("color") && !node.has("rgb")) {
    node.fault("color", "nothing, and the class is no colour word",
               "a colour: color: WORD or rgb: [R, G, B]");
  }
  return ball;
}

Obstacle read_obstacle(YamlNode& node, std::size_t number) {
  Obstacle obstacle;
  const std::string type = node.choice("type", obstacle_types);
  obstacle.name = node.text("name", type + "_" + std::to_string(number));
  YamlNode position = node.map("position");
  const double x = position.number("x_m", place_m), y = position.number("y_m", place_m);
  const double bottom = node.number("bottom_m", NumberRange::within(0, 20, "m"), 0.0);
  double height = 0;
  if (type == "box") {
    YamlNode size = node.map("size");
    const BoxShape box{
        {size.number("x_m", size_m(20)), size.number("y_m", size_m(20)), size.number("z_m", size_m(20))}};
    height = box.size_m.z();
    obstacle.shape = box;
  } else if (type == "cylinder") {
    const CylinderShape cylinder{node.number("radius_m", size_m(10)), node.number("height_m", size_m(20))};
    height = cylinder.height_m;
    obstacle.shape = cylinder;
  } else {
    const DiscShape disc{node.number("radius_m", size_m(10))};
    height = 2 * disc.radius_m;
    obstacle.shape = disc;
  }
  obstacle.center_m = {x, y, bottom + height / 2};
  if (type != "cylinder")
    obstacle.yaw_rad = node.number("yaw_rad", NumberRange::within(-6.2832, 6.2832, "rad"), 0.0);
  obstacle.material = read_material(node, {});
  return obstacle;
}

Rgb read_light_color(YamlNode& node, const Rgb& fallback) {
  const std::vector<double> rgb = node.numbers("rgb", NumberRange::within(0, 1000, ""), 3,
                                               std::vector<double>{fallback.x(), fallback.y(), fallback.z()});
  return {rgb[0], rgb[1], rgb[2]};
}

/// How a light changes: its list `changes`, each entry as the one before where it says nothing.
LightCourse read_course(YamlNode& light, double white_balance_k) {
  LightCourse course{white_balance_k, {}};
  LightKey key{0, white_balance_k, 1};
  for (YamlNode& item : light.list("changes")) {
    const double time_s = item.number("time_s", NumberRange::within(0, 3600, "s"));
    if (time_s < key.time_s) {
      item.fault("time_s", number_text(time_s), "a time not before that of the entry before");
    }
    key = {time_s, item.number("temperature_k", temperature_k, key.temperature_k),
           item.number("level", NumberRange::within(0, 100, ""), key.level)};
    course.keys.push_back(key);
  }
  return course;
}

void read_lights(YamlNode root, World& world) {
  const double white_balance_k =
      root.map("camera", false).number("white_balance_k", temperature_k, LightCourse{}.white_balance_k);
  const Rgb warm(4.2, 4.0, 3.7);
  std::vector<YamlNode> items = root.list("lights");
  if (items.empty()) {
    const Room& room = world.room;
    const double middle_y = (room.y_min_m + room.y_max_m) / 2, width = room.x_max_m - room.x_min_m;
    world.lights = {
        {{room.x_min_m + 0.3 * width, middle_y + 0.2 * (room.y_max_m - middle_y), room.height_m - 0.1},
         warm,
         0.2},
        {{room.x_min_m + 0.7 * width, middle_y - 0.2 * (room.y_max_m - middle_y), room.height_m - 0.1},
         warm,
         0.2}};
    world.ambient = {0.40, 0.41, 0.43};
  } else {
    world.ambient = Rgb::Zero();
  }
  for (YamlNode& node : items) {
    const std::string type = node.choice("type", {"point", "ambient"});
    const Rgb color = read_light_color(node, type == "point" ? warm : Rgb(0.40, 0.41, 0.43));
    const LightCourse course = read_course(node, white_balance_k);
    if (type == "ambient") {
      if (course.keys.empty()) {
        world.ambient += color;
      } else {
        world.changing_ambient.push_back({color, course});
      }
      continue;
    }
    Light light;
    YamlNode position = node.map("position");
    light.position_m = {position.number("x_m", place_m), position.number("y_m", place_m),
                        position.number("z_m", NumberRange::within(0.1, 20, "m"))};
    light.intensity = color;
    light.radius_m = node.number("radius_m", NumberRange::within(0, 2, "m"), 0.2);
    light.course = course;
    world.lights.push_back(light);
  }
  const double level = root.number("light_level", NumberRange::within(0, 100, ""), 1.0);
  for (Light& light : world.lights) light.intensity *= level;
  world.ambient *= level;
  for (AmbientLight& light : world.changing_ambient) light.intensity *= level;
}

/// The obstacles that the list names, then those that it strews between them.
template <typename WithoutFault>
void read_obstacles(YamlNode root, const WorldContext& context, WorldReading& reading,
                    const WithoutFault& without_fault) {
  std::vector<YamlNode> items = root.list("obstacles");
  const auto is_scatter = [](YamlNode& node) {
    return node.is_map() && node.has("type") && node.choice("type", obstacle_types) == "scatter";
  };
  std::vector<Obstacle>& obstacles = reading.world.obstacles;
  for (std::size_t k = 0; k < items.size(); ++k) {
    if (is_scatter(items[k])) continue;
    reading.obstacle_ok.push_back(
        without_fault([&] { obstacles.push_back(read_obstacle(items[k], k + 1)); }));
    reading.obstacle_item.push_back(k);
  }
  for (std::size_t k = 0; k < items.size(); ++k) {
    if (!is_scatter(items[k])) continue;
    scatter_obstacles(items[k], k, context.start, context.duration_s, context.seed, reading.world);
    reading.obstacle_ok.resize(obstacles.size(), true);
    reading.obstacle_item.resize(obstacles.size(), k);
  }
}

}  // namespace

WorldReading read_world(StrictYaml& yaml, const WorldContext& context) {
  YamlNode root = yaml.root();
  WorldReading reading;
  const auto without_fault = [&yaml](const auto& read) {
    const std::size_t before = yaml.faults().faults().size();
    read();
    return yaml.faults().faults().size() == before;
  };
  reading.room_ok = without_fault([&] { reading.world.room = read_room(root); });
  std::set<std::string> names;
  for (YamlNode& node : root.list("balls", true)) {
    reading.ball_ok.push_back(without_fault([&] {
      reading.world.balls.push_back(read_ball(node, reading.world.room));
      const std::string& name = reading.world.balls.back().name;
      if (!name.empty() && !names.insert(name).second)
        node.fault("name", name, "a name that no other ball has");
    }));
  }
  read_obstacles(root, context, reading, without_fault);
  read_lights(root, reading.world);
  return reading;
}

}  // namespace ballservo
