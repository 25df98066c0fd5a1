#include "app/scenario/world_options.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "calibration/base/numbers.hpp"
#include "calibration/base/random.hpp"
#include "calibration/color/color_file.hpp"

namespace ballservo {

namespace {

const NumberRange place_m = NumberRange::within(-100, 100, "m");
const NumberRange share_range = NumberRange::within(0, 1, "");
const NumberRange run_s = NumberRange::within(0, 3600, "s");
const NumberRange angle_rad = NumberRange::within(-6.2832, 6.2832, "rad");
const NumberRange speed_mps = NumberRange::within(-10, 10, "m/s");
const NumberRange temperature_k = NumberRange::within(min_temperature_k, max_temperature_k, "K");
constexpr double wall_gap_m = 1e-6;                    // so that rounding never puts a ball into the wall
const Rgb warm(4.2, 4.0, 3.7), dim(0.40, 0.41, 0.43);  // a lamp, light from everywhere

NumberRange size_m(double high) { return NumberRange::above(0, high, "m"); }

/// A colour by its word (`color: red`) or its reflectances (`rgb: [0.7, 0.05, 0.03]`). Returns whether there
/// is either.
bool declare_color(OptionVisitor& v, Rgb& color, const std::string& suffix, const Fallback& fallback = {}) {
  const std::string word_key = "color" + suffix, rgb_key = "rgb" + suffix;
  static const std::vector<std::string> words{"red",    "orange", "yellow", "green", "cyan", "blue",
                                              "purple", "pink",   "white",  "black", "grey", "brown"};
  std::optional<std::string> word;
  v.maybe(word_key, word, [&](const std::string& key, std::string& name) {
    v.choice(key, name, words, "colour by its word, instead of " + rgb_key, otherwise("none"));
  });
  const bool has_rgb = v.present(rgb_key, false);
  v.require(!word || !has_rgb, rgb_key, "both " + word_key + " and " + rgb_key, "one of them");
  v.vector(rgb_key, color, share_range, "colour by its linear reflectances", fallback);
  if (word) color = color_from_word(*word).value_or(color);
  return word || has_rgb;
}

void declare_highlight(OptionVisitor& v, Material& material) {
  v.number("specular", material.specular, share_range, "strength of the highlight");
  v.number("shininess", material.shininess, NumberRange::within(1, 1000, ""), "exponent of the highlight");
}

void declare(OptionVisitor& v, Material& material) {
  Texture& texture = material.texture;
  v.one_of("pattern", texture.pattern, names_of(all_patterns, pattern_name), "how the two colours alternate");
  declare_color(v, texture.color, "");
  declare_color(v, texture.color_2, "_2");
  v.number("scale_m", texture.scale_m, NumberRange::within(0.01, 10, "m"),
           "of the pattern: a check, a tile, a board");
  declare_highlight(v, material);
}

void declare(OptionVisitor& v, Room& room) {
  v.number("x_min_m", room.x_min_m, place_m, "wall behind");
  v.number("x_max_m", room.x_max_m, place_m, "wall ahead");
  v.number("y_min_m", room.y_min_m, place_m, "wall on the right");
  v.number("y_max_m", room.y_max_m, place_m, "wall on the left");
  v.number("height_m", room.height_m, NumberRange::within(0.5, 20, "m"), "of the ceiling");
  v.require(room.x_max_m - room.x_min_m >= 1, "x_max_m", "no room to x_min_m",
            "at least 1 m more than x_min_m");
  v.require(room.y_max_m - room.y_min_m >= 1, "y_max_m", "no room to y_min_m",
            "at least 1 m more than y_min_m");
  v.map("floor", [&] { declare(v, room.floor); });
  v.map("walls", [&] { declare(v, room.wall); });
  v.map("ceiling", [&] { declare(v, room.ceiling); });
}

/// `position`, on the floor.
void declare_position(OptionVisitor& v, Eigen::Vector2d& p_m) {
  v.number("x_m", p_m.x(), place_m, "of the centre", required);
  v.number("y_m", p_m.y(), place_m, "of the centre", required);
}

/// All but `type`, which is known.
void declare_obstacle(OptionVisitor& v, const std::string& type, Obstacle& obstacle) {
  v.text("name", obstacle.name, "for messages and reports", otherwise("its type and number"));
  Eigen::Vector2d p_m(0, 0);
  double bottom_m = 0, height_m = 0;
  v.map("position", required, [&] { declare_position(v, p_m); });
  v.number("bottom_m", bottom_m, NumberRange::within(0, 20, "m"), "its lower edge over the floor");
  v.only_if(type == "box", "type: box", [&] {
    BoxShape box;
    v.map("size", required, [&] {
      v.number("x_m", box.size_m.x(), size_m(20), "along its own x axis", required);
      v.number("y_m", box.size_m.y(), size_m(20), "along its own y axis", required);
      v.number("z_m", box.size_m.z(), size_m(20), "height", required);
    });
    obstacle.shape = box;
    height_m = box.size_m.z();
  });
  v.only_if(type == "cylinder", "type: cylinder", [&] {
    CylinderShape cylinder;
    v.number("radius_m", cylinder.radius_m, size_m(10), "its radius", required);
    v.number("height_m", cylinder.height_m, size_m(20), "its height", required);
    obstacle.shape = cylinder;
    height_m = cylinder.height_m;
  });
  v.only_if(type == "disc", "type: disc", [&] {
    DiscShape disc;
    v.number("radius_m", disc.radius_m, size_m(10), "of the upright plate", required);
    obstacle.shape = disc;
    height_m = 2 * disc.radius_m;
  });
  obstacle.center_m = {p_m.x(), p_m.y(), bottom_m + height_m / 2};
  v.only_if(type != "cylinder", "type: box, disc", [&] {
    v.number("yaw_rad", obstacle.yaw_rad, angle_rad, "turned counter-clockwise, seen from above");
  });
  declare(v, obstacle.material);
}

void declare_obstacles(OptionVisitor& v, WorldOptions& options) {
  v.list("obstacles", [&](std::size_t item) {
    std::string type;
    const bool type_ok = v.without_fault([&] {
      v.choice("type", type, {"box", "cylinder", "disc", "scatter"}, "scatter: things that the seed strews",
               required);
    });
    v.only_if(type != "scatter", "type: box, cylinder, disc", [&] {
      Obstacle obstacle;
      obstacle.name = type + "_" + std::to_string(item + 1);
      const bool ok = v.without_fault([&] { declare_obstacle(v, type, obstacle); });
      options.obstacle_ok.push_back(type_ok && ok);
      options.obstacle_item.push_back(item);
      options.world.obstacles.push_back(std::move(obstacle));
    });
    v.only_if(type == "scatter", "type: scatter", [&] {
      const Room& room = options.world.room;
      Scatter scatter;
      scatter.x_m = {room.x_min_m, room.x_max_m};
      scatter.y_m = {room.y_min_m, room.y_max_m};
      declare(v, scatter);
      options.scattered.emplace_back(item, scatter);
    });
  });
}

void declare(OptionVisitor& v, LinearMotion& motion) {
  motion.duration_s = 3600;
  v.map("velocity", required, [&] {
    v.number("x_mps", motion.velocity_mps.x(), speed_mps, "velocity", required);
    v.number("y_mps", motion.velocity_mps.y(), speed_mps, "velocity", required);
  });
  v.number("start_s", motion.start_s, run_s, "rests before");
  v.number("duration_s", motion.duration_s, run_s, "moves for so long");
}

void declare(OptionVisitor& v, CircleMotion& motion) {
  v.map("center", required, [&] { declare_position(v, motion.center_m); });
  v.number("rate_radps", motion.rate_radps, NumberRange::within(-10, 10, "rad/s"), "counter-clockwise",
           required);
}

/// From `motion`'s one point, at 0 s, on.
void declare(OptionVisitor& v, WaypointMotion& motion) {
  const double start_z_m = motion.points.front().position_m.z();
  v.list("points", 0, required, [&](std::size_t) {
    WaypointMotion::Point point{0, {0, 0, start_z_m}};
    v.number("time_s", point.time_s, NumberRange::above(0, 3600, "s"), "when it is there", required);
    v.require(point.time_s > motion.points.back().time_s, "time_s", number_text(point.time_s),
              "a time after the point before (the start is at 0 s)");
    v.number("x_m", point.position_m.x(), place_m, "of its centre", required);
    v.number("y_m", point.position_m.y(), place_m, "of its centre", required);
    v.number("z_m", point.position_m.z(), place_m, "of its centre", otherwise("as at the start"));
    motion.points.push_back(point);
  });
}

void declare(OptionVisitor& v, RollingMotion& motion) {
  double speed = 0, heading_rad = 0;
  v.number("speed_mps", speed, NumberRange::within(0, 10, "m/s"), "at the start", required);
  v.number("heading_rad", heading_rad, angle_rad, "from the x axis, counter-clockwise", required);
  motion.velocity_mps = speed * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
  v.number("start_s", motion.start_s, run_s, "rests before");
  v.number("friction_mps2", motion.friction_mps2, NumberRange::within(0, 10, "m/s^2"),
           "deceleration along the way");
  v.number("restitution", motion.restitution, share_range, "share of the speed that a wall gives back");
}

void declare(OptionVisitor& v, CarriedWays& ways) {
  v.number("speed_mps", ways.speed_mps, NumberRange::above(0, 10, "m/s"), "up, along and down", required);
  v.number("height_m", ways.height_m, NumberRange::within(0, 20, "m"), "by which it is lifted", required);
  declare_range(v, "rest_s", ways.rest_s, run_s, "before each way");
  declare_range(v, "x_m", ways.x_m, place_m, "where it is put down", otherwise("the room"));
  declare_range(v, "y_m", ways.y_m, place_m, "where it is put down", otherwise("the room"));
  v.number("until_s", ways.end_s, NumberRange::above(0, 3600, "s"), "it lies for good",
           otherwise("the run's end"));
}

void declare_motion(OptionVisitor& v, Ball& ball, WorldOptions& options, double duration_s) {
  const Room& room = options.world.room;
  const double margin_m = ball.radius_m() + wall_gap_m;
  const Eigen::Vector2d low_m = Eigen::Vector2d(room.x_min_m, room.y_min_m).array() + margin_m,
                        high_m = Eigen::Vector2d(room.x_max_m, room.y_max_m).array() - margin_m;
  std::string type = "static";
  v.choice("type", type, {"static", "linear", "circle", "waypoints", "rolling", "carried"}, "how it moves");
  const auto moves = [&](const std::string& name, auto motion) {
    v.only_if(type == name, "type: " + name, [&] {
      declare(v, motion);
      ball.motion = motion;
    });
  };
  moves("linear", LinearMotion{});
  moves("circle", CircleMotion{});
  moves("waypoints", WaypointMotion{{{0, ball.position_m}}});
  moves("rolling", RollingMotion{{0, 0}, 0, 0, 1, low_m, high_m});
  v.only_if(type == "carried", "type: carried", [&] {
    CarriedWays ways{0.2, 0, {1, 3}, {low_m.x(), high_m.x()}, {low_m.y(), high_m.y()}, duration_s};
    declare(v, ways);
    options.carried.emplace_back(options.world.balls.size(), ways);
  });
}

/// A ball shows the colour that its class is named for unless it says otherwise.
void declare_ball(OptionVisitor& v, Ball& ball, WorldOptions& options, double duration_s) {
  v.text("name", ball.name, "by which `target` names it", required);
  v.require(!ball.name.empty() || !v.present("name", true), "name", "nothing", "a name");
  v.text("class", ball.class_name, "its colour's class", required);
  v.require(is_class_name(ball.class_name) || !v.present("class", true), "class", ball.class_name,
            class_name_rule);
  v.number("diameter_m", ball.diameter_m, size_m(2), "its diameter", required);
  v.map("position", required, [&] {
    ball.position_m.z() = ball.diameter_m / 2;
    v.number("x_m", ball.position_m.x(), place_m, "of its centre at 0 s", required);
    v.number("y_m", ball.position_m.y(), place_m, "of its centre at 0 s", required);
    v.number("z_m", ball.position_m.z(), place_m, "of its centre at 0 s", otherwise("its radius"));
  });
  v.map("motion", [&] { declare_motion(v, ball, options, duration_s); });
  v.boolean("sonar", ball.sonar, "whether a sonar echoes from it");
  const auto by_class = color_from_word(ball.class_name);
  ball.material = painted_ball(by_class.value_or(Rgb(0.5, 0.5, 0.5)));
  const bool named = declare_color(v, ball.material.texture.color, "", otherwise("its class's"));
  declare_highlight(v, ball.material);
  v.require(by_class || named, "color", "nothing, and the class is no colour word",
            "a colour: color: WORD or rgb: [R, G, B]");
}

void declare_balls(OptionVisitor& v, WorldOptions& options, double duration_s) {
  std::set<std::string> names;
  v.list("balls", 0, required, [&](std::size_t) {
    Ball ball;
    options.ball_ok.push_back(v.without_fault([&] {
      declare_ball(v, ball, options, duration_s);
      v.require(ball.name.empty() || names.insert(ball.name).second, "name", ball.name,
                "a name that no other ball has");
    }));
    options.world.balls.push_back(std::move(ball));
  });
}

/// How a light changes: each entry as the one before where it says nothing.
void declare_changes(OptionVisitor& v, LightCourse& course) {
  LightKey key{0, course.white_balance_k, 1};
  v.list("changes", [&](std::size_t) {
    const double before_s = key.time_s;
    v.number("time_s", key.time_s, run_s, "linear from one entry to the next, at once where two share a time",
             required);
    v.require(key.time_s >= before_s, "time_s", number_text(key.time_s),
              "a time not before that of the entry before");
    v.number("temperature_k", key.temperature_k, temperature_k, "colour temperature",
             otherwise("as before; at first the white balance"));
    v.number("level", key.level, NumberRange::within(0, 100, ""), "factor on rgb",
             otherwise("as before; at first 1"));
    course.keys.push_back(key);
  });
}

void declare_light(OptionVisitor& v, World& world, double white_balance_k) {
  std::string type;
  v.choice("type", type, {"point", "ambient"}, "a lamp, or light from everywhere", required);
  Light light;
  light.intensity = type == "point" ? warm : dim;
  light.course.white_balance_k = white_balance_k;
  light.radius_m = 0.2;
  v.vector("rgb", light.intensity, NumberRange::within(0, 1000, ""),
           "what white shows at 1 m from a lamp, or in this light from everywhere",
           otherwise("a warm room's"));
  declare_changes(v, light.course);
  v.only_if(type == "point", "type: point", [&] {
    v.map("position", required, [&] {
      v.number("x_m", light.position_m.x(), place_m, "of the lamp", required);
      v.number("y_m", light.position_m.y(), place_m, "of the lamp", required);
      v.number("z_m", light.position_m.z(), NumberRange::within(0.1, 20, "m"), "of the lamp", required);
    });
    v.number("radius_m", light.radius_m, NumberRange::within(0, 2, "m"), "of the lamp: makes shadows soft");
  });
  if (type == "point") {
    world.lights.push_back(light);
  } else if (light.course.keys.empty()) {
    world.ambient += light.intensity;
  } else {
    world.changing_ambient.push_back({light.intensity, light.course});
  }
}

/// Where a scenario names no lights: two lamps under the ceiling, in a hall for each 8 m of its length.
void add_usual_lights(World& world) {
  const Room& room = world.room;
  const double middle_y = (room.y_min_m + room.y_max_m) / 2, length = room.x_max_m - room.x_min_m;
  const int stretches = std::max(1, static_cast<int>(length / 8));
  const auto add = [&](double along, double aside) {
    world.lights.push_back({{room.x_min_m + along * length / stretches,
                             middle_y + aside * (room.y_max_m - middle_y), room.height_m - 0.1},
                            warm,
                            0.2});
  };
  for (int i = 0; i < stretches; ++i) {
    add(i + 0.3, 0.2);
    add(i + 0.7, -0.2);
  }
  world.ambient = dim;
}

void declare_lights(OptionVisitor& v, World& world, double white_balance_k) {
  world.ambient = Rgb::Zero();
  std::size_t count = 0;
  v.list("lights", [&](std::size_t item) {
    declare_light(v, world, white_balance_k);
    count = item + 1;
  });
  if (count == 0) add_usual_lights(world);
  double level = 1;
  v.number("light_level", level, NumberRange::within(0, 100, ""), "factor on all lights");
  for (Light& light : world.lights) light.intensity *= level;
  world.ambient *= level;
  for (AmbientLight& light : world.changing_ambient) light.intensity *= level;
}

}  // namespace

WorldOptions::WorldOptions() {
  world.room.floor.texture = {Pattern::wood, {0.52, 0.36, 0.21}, {0.30, 0.18, 0.09}, 0.12};
  world.room.wall.texture = {Pattern::noise, {0.66, 0.65, 0.60}, {0.58, 0.57, 0.53}, 0.6};
  world.room.ceiling.texture.color = {0.80, 0.80, 0.78};
}

void declare(OptionVisitor& v, WorldOptions& options, double white_balance_k, double duration_s) {
  options.room_ok = v.without_fault([&] { v.map("room", [&] { declare(v, options.world.room); }); });
  declare_obstacles(v, options);
  declare_balls(v, options, duration_s);
  declare_lights(v, options.world, white_balance_k);
}

void draw_world(WorldOptions& options, const Pose2& start, double duration_s, std::uint64_t seed) {
  World& world = options.world;
  for (const auto& [index, ways] : options.carried) {
    RandomEngine engine = random_stream(seed, "carried", index);
    world.balls[index].motion = carry(world.balls[index], ways, world.obstacles, engine);
  }
  for (const auto& [item, scatter] : options.scattered) {
    scatter_things(scatter, item, {start, duration_s, seed}, world);
    options.obstacle_ok.resize(world.obstacles.size(), true);
    options.obstacle_item.resize(world.obstacles.size(), item);
  }
}

}  // namespace ballservo
