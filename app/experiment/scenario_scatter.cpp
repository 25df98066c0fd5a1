#include "app/experiment/scenario_scatter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/files/random.hpp"

namespace ballservo {

namespace {

struct Range {
  double low = 0, high = 0;
  double draw(RandomEngine& engine) const { return uniform(engine, low, high); }
};

struct Scatter {
  std::string shape;
  Range count, size_m, height_m, bottom_m, x_m, y_m;
  double gap_m = 0, start_gap_m = 0, ball_gap_m = 0;
  std::string color;  // empty: any
};

Range read_range(YamlNode& node, const std::string& key, const NumberRange& allowed, const Range& fallback) {
  const std::vector<double> values =
      node.numbers(key, allowed, 2, std::vector<double>{fallback.low, fallback.high});
  if (values[0] > values[1]) node.fault(key, "bounds in falling order", "[low, high]");
  return {values[0], values[1]};
}

Scatter read(YamlNode& node, const Room& room) {
  Scatter scatter;
  scatter.shape = node.choice("shape", {"box", "cylinder", "disc"});
  scatter.count = read_range(node, "count", NumberRange::within(0, 200, ""), {1, 1});
  scatter.size_m = read_range(node, "size_m", {0, 5, true, false, "m"}, {0.2, 0.6});
  scatter.height_m = read_range(node, "height_m", {0, 5, true, false, "m"}, {0.3, 1.0});
  scatter.bottom_m = read_range(node, "bottom_m", NumberRange::within(0, 5, "m"), {0, 0});
  const NumberRange place_m = NumberRange::within(-100, 100, "m");
  scatter.x_m = read_range(node, "x_m", place_m, {room.x_min_m, room.x_max_m});
  scatter.y_m = read_range(node, "y_m", place_m, {room.y_min_m, room.y_max_m});
  scatter.gap_m = node.number("gap_m", NumberRange::within(0, 5, "m"), 0.1);
  scatter.start_gap_m = node.number("start_gap_m", NumberRange::within(0, 5, "m"), 0.6);
  scatter.ball_gap_m = node.number("ball_gap_m", NumberRange::within(0, 5, "m"), 0.2);
  static const std::vector<std::string> words{"any",    "red",  "orange", "yellow", "green", "cyan", "blue",
                                              "purple", "pink", "white",  "black",  "grey",  "brown"};
  scatter.color = node.choice("color", words, "any");
  return scatter;
}

double outline_radius_m(const Obstacle& obstacle) {
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape)) return box->size_m.head<2>().norm() / 2;
  if (const auto* cylinder = std::get_if<CylinderShape>(&obstacle.shape)) return cylinder->radius_m;
  return std::get<DiscShape>(obstacle.shape).radius_m;
}

/// Whether it keeps its distances; by circles around the outlines, so by more than need be.
bool fits(const Obstacle& obstacle, const Scatter& scatter, const Pose2& start, double duration_s,
          const World& world) {
  const Eigen::Vector2d p = obstacle.center_m.head<2>();
  const double radius = outline_radius_m(obstacle), reach = radius + scatter.gap_m;
  const Room& room = world.room;
  if (p.x() - reach < room.x_min_m || p.x() + reach > room.x_max_m || p.y() - reach < room.y_min_m ||
      p.y() + reach > room.y_max_m || obstacle.top_m() > room.height_m) {
    return false;
  }
  if ((p - Eigen::Vector2d(start.x_m, start.y_m)).norm() < radius + scatter.start_gap_m) return false;
  for (const Ball& ball : world.balls) {
    const double end_s = std::holds_alternative<StaticMotion>(ball.motion) ? 0.0 : duration_s;
    for (double time_s = 0; time_s <= end_s; time_s += 0.1) {
      if ((p - ball.p_WB(time_s).head<2>()).norm() < radius + ball.radius_m() + scatter.ball_gap_m)
        return false;
    }
  }
  return std::all_of(world.obstacles.begin(), world.obstacles.end(), [&](const Obstacle& other) {
    return (p - other.center_m.head<2>()).norm() >= reach + outline_radius_m(other);
  });
}

Obstacle draw(const Scatter& scatter, RandomEngine& engine) {
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
  static constexpr std::array<const char*, 6> words{"green", "blue", "grey", "brown", "white", "purple"};
  const std::uint32_t any = uniform_index(engine, words.size());
  obstacle.material.texture.color = *color_from_word(scatter.color == "any" ? words[any] : scatter.color);
  return obstacle;
}

}  // namespace

void scatter_obstacles(YamlNode& node, std::size_t item, const Pose2& start, double duration_s,
                       std::uint64_t seed, World& world) {
  const std::string name = node.text("name", node.choice("shape", {"box", "cylinder", "disc"}));
  const Scatter scatter = read(node, world.room);
  RandomEngine engine = random_stream(seed, "scatter", item);
  const auto low = static_cast<std::uint32_t>(scatter.count.low),
             high = static_cast<std::uint32_t>(scatter.count.high);
  const std::uint32_t count = low + uniform_index(engine, std::max(high, low) - low + 1);
  for (std::uint32_t k = 0; k < count; ++k) {
    for (int attempt = 0; attempt < 100; ++attempt) {
      Obstacle obstacle = draw(scatter, engine);
      if (!fits(obstacle, scatter, start, duration_s, world)) continue;
      obstacle.name = name + "_" + std::to_string(item + 1) + "_" + std::to_string(k + 1);
      world.obstacles.push_back(std::move(obstacle));
      break;
    }
  }
}

}  // namespace ballservo
