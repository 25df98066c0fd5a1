#include "app/scenario/scenario_balls.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "app/scenario/carried_ball.hpp"
#include "app/scenario/scenario_material.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {

namespace {

const NumberRange place_m = NumberRange::within(-100, 100, "m");
const NumberRange share = NumberRange::within(0, 1, "");
constexpr double wall_gap_m = 1e-6;  // so that rounding never puts a ball into the wall

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
  const double margin_m = radius_m + wall_gap_m;
  motion.low_m = Eigen::Vector2d(room.x_min_m, room.y_min_m).array() + margin_m;
  motion.high_m = Eigen::Vector2d(room.x_max_m, room.y_max_m).array() - margin_m;
  return motion;
}

WaypointMotion read_carried(YamlNode& node, const Ball& ball, const BallContext& context) {
  const Room& room = context.world.room;
  CarriedWays ways;
  ways.speed_mps = node.number("speed_mps", {0, 10, true, false, "m/s"});
  ways.height_m = node.number("height_m", NumberRange::within(0, 20, "m"));
  ways.rest_s = read_drawn_range(node, "rest_s", NumberRange::within(0, 3600, "s"), {1, 3});
  const double margin_m = ball.radius_m() + wall_gap_m;
  ways.x_m = read_drawn_range(node, "x_m", place_m, {room.x_min_m + margin_m, room.x_max_m - margin_m});
  ways.y_m = read_drawn_range(node, "y_m", place_m, {room.y_min_m + margin_m, room.y_max_m - margin_m});
  ways.end_s = node.number("until_s", {0, 3600, true, false, "s"}, context.duration_s);
  RandomEngine engine = random_stream(context.seed, "carried", context.index);
  return carry(ball, ways, context.world.obstacles, engine);
}

Motion read_motion(YamlNode& item, const Ball& ball, const BallContext& context) {
  YamlNode node = item.map("motion", false);
  const std::string type =
      node.choice("type", {"static", "linear", "circle", "waypoints", "rolling", "carried"}, "static");
  if (type == "rolling") return read_rolling(node, context.world.room, ball.radius_m());
  if (type == "carried") return read_carried(node, ball, context);
  if (type == "waypoints") return read_waypoints(node, ball.position_m);
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

}  // namespace

Ball read_ball(YamlNode& node, const BallContext& context) {
  Ball ball;
  ball.name = node.text("name");
  if (ball.name.empty() && node.has("name")) node.fault("name", "nothing", "a name");
  ball.class_name = node.text("class");
  if (node.has("class") && !is_class_name(ball.class_name)) {
    node.fault("class", ball.class_name, "1 to 64 of a-z, 0-9 and _, beginning with a letter");
  }
  ball.diameter_m = node.number("diameter_m", {0, 2, true, false, "m"});
  YamlNode position = node.map("position");
  ball.position_m = {position.number("x_m", place_m), position.number("y_m", place_m),
                     position.number("z_m", place_m, ball.diameter_m / 2)};
  ball.motion = read_motion(node, ball, context);
  ball.sonar = node.boolean("sonar", false);
  const auto by_class = color_from_word(ball.class_name);
  const Material painted = painted_ball(by_class.value_or(Rgb(0.5, 0.5, 0.5)));
  ball.material = painted;
  ball.material.texture.color = read_color(node, painted.texture.color);
  ball.material.specular = node.number("specular", share, painted.specular);
  ball.material.shininess = node.number("shininess", NumberRange::within(1, 1000, ""), painted.shininess);
  if (!by_class && !node.has("color") && !node.has("rgb")) {
    node.fault("color", "nothing, and the class is no colour word",
               "a colour: color: WORD or rgb: [R, G, B]");
  }
  return ball;
}

}  // namespace ballservo
