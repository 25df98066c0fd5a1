#include "app/scenario/scatter.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>

#include "calibration/base/random.hpp"

namespace ballservo {

namespace {

/// What a thing that was drawn takes up: seen from above, the circle around its outline.
struct Place {
  Eigen::Vector2d p;
  double radius_m = 0, top_m = 0;
};

Place place_of(const Obstacle& obstacle) {
  return {obstacle.center_m.head<2>(), obstacle.outline_radius_m(), obstacle.top_m()};
}

Place place_of(const Ball& ball) {
  return {ball.position_m.head<2>(), ball.radius_m(), ball.position_m.z() + ball.radius_m()};
}

bool fits(const Place& place, const Scatter& scatter, const ScatterContext& context, const World& world) {
  const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(place.radius_m + scatter.gap_m);
  const Room& room = world.room;
  const Eigen::AlignedBox2d floor(Eigen::Vector2d(room.x_min_m, room.y_min_m),
                                  Eigen::Vector2d(room.x_max_m, room.y_max_m));
  if (!floor.contains(Eigen::AlignedBox2d(place.p - reach_m, place.p + reach_m)) ||
      place.top_m > room.height_m) {
    return false;
  }
  const auto clear_of = [&place](const Eigen::Vector2d& p, double radius_m, double gap_m) {
    return (place.p - p).norm() >= place.radius_m + radius_m + gap_m;
  };
  if (!clear_of({context.start.x_m, context.start.y_m}, 0, scatter.start_gap_m)) return false;
  for (const Ball& ball : world.balls) {
    const double end_s = std::holds_alternative<StaticMotion>(ball.motion) ? 0.0 : context.duration_s;
    for (double time_s = 0; time_s <= end_s; time_s += 0.1) {
      if (!clear_of(ball.p_WB(time_s).head<2>(), ball.radius_m(), scatter.ball_gap_m)) return false;
    }
  }
  return std::all_of(world.obstacles.begin(), world.obstacles.end(), [&](const Obstacle& other) {
    return clear_of(other.center_m.head<2>(), other.outline_radius_m(), scatter.gap_m);
  });
}

std::string draw_color(const Scatter& scatter, RandomEngine& engine) {
  static constexpr std::array<const char*, 6> words{"green", "blue", "grey", "brown", "white", "purple"};
  const std::uint32_t any = uniform_index(engine, words.size());
  return scatter.color == "any" ? words[any] : scatter.color;
}

Obstacle draw_obstacle(const Scatter& scatter, RandomEngine& engine) {
  Obstacle obstacle;
  double height = scatter.height_m.draw(engine);
  const double a = scatter.size_m.draw(engine), b = scatter.size_m.draw(engine);
  if (scatter.shape == "box") {
    obstacle.shape = BoxShape{{a, b, height}};
  } else if (scatter.shape == "cylinder") {
    obstacle.shape = CylinderShape{a / 2, height};
  } else {
    obstacle.shape = DiscShape{a / 2};
    height = a;
  }
  obstacle.yaw_rad = scatter.shape == "cylinder" ? 0.0 : uniform(engine, -3.1, 3.1);
  const double bottom = scatter.bottom_m.draw(engine);
  const double x = scatter.x_m.draw(engine), y = scatter.y_m.draw(engine);
  obstacle.center_m = {x, y, bottom + height / 2};
  obstacle.material.texture.color = *color_from_word(draw_color(scatter, engine));
  return obstacle;
}

Ball draw_ball(const Scatter& scatter, RandomEngine& engine) {
  Ball ball;
  ball.diameter_m = scatter.size_m.draw(engine);
  const double bottom = scatter.bottom_m.draw(engine);
  const double x = scatter.x_m.draw(engine), y = scatter.y_m.draw(engine);
  ball.position_m = {x, y, bottom + ball.radius_m()};
  ball.class_name = draw_color(scatter, engine);
  ball.material = painted_ball(*color_from_word(ball.class_name));
  return ball;
}

/// As many as the seed says; each is drawn until it fits, a hundred times at the most.
template <typename Thing>
void strew(Thing (*draw)(const Scatter&, RandomEngine&), const Scatter& scatter, const std::string& name,
           const ScatterContext& context, RandomEngine& engine, World& world, std::vector<Thing>& things) {
  const auto low = static_cast<std::uint32_t>(scatter.count.low),
             high = static_cast<std::uint32_t>(scatter.count.high);
  const std::uint32_t count = low + uniform_index(engine, std::max(high, low) - low + 1);
  for (std::uint32_t k = 0; k < count; ++k) {
    for (int attempt = 0; attempt < 100; ++attempt) {
      Thing thing = draw(scatter, engine);
      if (!fits(place_of(thing), scatter, context, world)) continue;
      thing.name = name + "_" + std::to_string(k + 1);
      things.push_back(std::move(thing));
      break;
    }
  }
}

}  // namespace

void declare(OptionVisitor& v, Scatter& scatter) {
  static const std::vector<std::string> words{"any",    "red",  "orange", "yellow", "green", "cyan", "blue",
                                              "purple", "pink", "white",  "black",  "grey",  "brown"};
  const NumberRange size_m = NumberRange::above(0, 5, "m"), gap_m = NumberRange::within(0, 5, "m"),
                    place_m = NumberRange::within(-100, 100, "m");
  v.choice("shape", scatter.shape, {"box", "cylinder", "disc", "ball"}, "of each thing", required);
  declare_range(v, "count", scatter.count, NumberRange::within(0, 200, ""), "how many");
  declare_range(v, "size_m", scatter.size_m, size_m, "sides or diameter");
  declare_range(v, "height_m", scatter.height_m, size_m, "of boxes and cylinders");
  declare_range(v, "bottom_m", scatter.bottom_m, gap_m, "of the lower edge over the floor");
  declare_range(v, "x_m", scatter.x_m, place_m, "of the centres", otherwise("the room"));
  declare_range(v, "y_m", scatter.y_m, place_m, "of the centres", otherwise("the room"));
  v.number("gap_m", scatter.gap_m, gap_m, "to other obstacles and walls, at least");
  v.number("start_gap_m", scatter.start_gap_m, gap_m, "to the robot's start, at least");
  v.number("ball_gap_m", scatter.ball_gap_m, gap_m, "to balls and their ways, at least");
  v.choice("color", scatter.color, words, "a colour word; any: drawn from six");
  scatter.name = scatter.shape;
  v.text("name", scatter.name, "names begin with it", otherwise("the shape"));
}

void scatter_things(const Scatter& scatter, std::size_t item, const ScatterContext& context, World& world) {
  const std::string name = scatter.name + "_" + std::to_string(item + 1);
  RandomEngine engine = random_stream(context.seed, "scatter", item);
  if (scatter.shape == "ball") {
    strew(draw_ball, scatter, name, context, engine, world, world.balls);
  } else {
    strew(draw_obstacle, scatter, name, context, engine, world, world.obstacles);
  }
}

namespace {

constexpr double gap_m = 0.05;
constexpr int max_tries = 100, max_ways = 1000;

bool is_clear(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, double radius_m,
              const std::vector<Obstacle>& obstacles) {
  const Eigen::Vector2d way = to_m - from_m;
  return std::all_of(obstacles.begin(), obstacles.end(), [&](const Obstacle& obstacle) {
    const Eigen::Vector2d away = obstacle.center_m.head<2>() - from_m;
    const double share = way.isZero() ? 0.0 : std::clamp(way.dot(away) / way.squaredNorm(), 0.0, 1.0);
    return (away - share * way).norm() >= obstacle.outline_radius_m() + radius_m + gap_m;
  });
}

}  // namespace

WaypointMotion carry(const Ball& ball, const CarriedWays& ways, const std::vector<Obstacle>& obstacles,
                     RandomEngine& engine) {
  const auto next_place = [&](const Eigen::Vector3d& from_m) -> std::optional<Eigen::Vector3d> {
    for (int tries = 0; tries < max_tries; ++tries) {
      const Eigen::Vector3d to_m(ways.x_m.draw(engine), ways.y_m.draw(engine), from_m.z());
      if (is_clear(from_m.head<2>(), to_m.head<2>(), ball.radius_m(), obstacles)) return to_m;
    }
    return std::nullopt;
  };
  const Eigen::Vector3d lift_m(0, 0, ways.height_m);
  WaypointMotion motion{{{0, ball.position_m}}};
  const auto go = [&](const Eigen::Vector3d& to_m) {
    const WaypointMotion::Point from = motion.points.back();
    motion.points.push_back({from.time_s + (to_m - from.position_m).norm() / ways.speed_mps, to_m});
  };
  for (int way = 0; way < max_ways; ++way) {
    const WaypointMotion::Point lying = motion.points.back();
    const auto to_m = next_place(lying.position_m);
    if (!to_m) break;
    const double lifted_s = lying.time_s + ways.rest_s.draw(engine);
    const double length_m = 2 * ways.height_m + (*to_m - lying.position_m).norm();
    if (lifted_s + length_m / ways.speed_mps > ways.end_s) break;
    motion.points.push_back({lifted_s, lying.position_m});
    go(lying.position_m + lift_m);
    go(*to_m + lift_m);
    go(*to_m);
  }
  return motion;
}

}  // namespace ballservo
