#include "app/scenario/scenario_world.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "app/scenario/scenario_balls.hpp"
#include "app/scenario/scenario_material.hpp"
#include "app/scenario/scenario_scatter.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

namespace {

const NumberRange place_m = NumberRange::within(-100, 100, "m");
const NumberRange share = NumberRange::within(0, 1, "");
const NumberRange temperature_k = NumberRange::within(min_temperature_k, max_temperature_k, "K");

const std::vector<std::string> obstacle_types{"box", "cylinder", "disc", "scatter"};

NumberRange size_m(double high) { return {0, high, true, false, "m"}; }

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

bool is_scatter(YamlNode& node) {
  return node.is_map() && node.has("type") && node.choice("type", obstacle_types) == "scatter";
}

}  // namespace

WorldReading read_world(StrictYaml& yaml, const ScatterContext& context) {
  YamlNode root = yaml.root();
  WorldReading reading;
  const auto without_fault = [&yaml](const auto& read) {
    const std::size_t before = yaml.faults().faults().size();
    read();
    return yaml.faults().faults().size() == before;
  };
  World& world = reading.world;
  reading.room_ok = without_fault([&] { world.room = read_room(root); });
  std::vector<YamlNode> items = root.list("obstacles");
  for (std::size_t k = 0; k < items.size(); ++k) {
    if (is_scatter(items[k])) continue;
    reading.obstacle_ok.push_back(
        without_fault([&] { world.obstacles.push_back(read_obstacle(items[k], k + 1)); }));
    reading.obstacle_item.push_back(k);
  }
  std::set<std::string> names;
  for (YamlNode& node : root.list("balls", true)) {
    reading.ball_ok.push_back(without_fault([&] {
      world.balls.push_back(read_ball(node, {world, context.duration_s, context.seed, world.balls.size()}));
      const std::string& name = world.balls.back().name;
      if (!name.empty() && !names.insert(name).second)
        node.fault("name", name, "a name that no other ball has");
    }));
  }
  for (std::size_t k = 0; k < items.size(); ++k) {
    if (!is_scatter(items[k])) continue;
    scatter_things(items[k], k, context, world);
    reading.obstacle_ok.resize(world.obstacles.size(), true);
    reading.obstacle_item.resize(world.obstacles.size(), k);
  }
  read_lights(root, world);
  return reading;
}

}  // namespace ballservo
