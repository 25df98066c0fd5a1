#include "app/scenario/carried_ball.hpp"

#include <algorithm>
#include <optional>

namespace ballservo {

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
