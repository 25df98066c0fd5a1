#include "servo/simulation/world/world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace ballservo {

namespace {

template <typename... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};
template <typename... Cases>
Overload(Cases...) -> Overload<Cases...>;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Half the thickness of a disc seen from above: enough to have an outline (m).
constexpr double disc_half_thickness_m = 0.002;

/// How far a shape reaches from its centre: over the floor, up and down, in space.
struct Extent {
  double outline_radius_m, half_height_m, bounding_radius_m;
};
Extent extent_of(const Shape& shape) {
  return std::visit(
      Overload{[](const BoxShape& box) -> Extent {
                 return {box.size_m.head<2>().norm() / 2, box.size_m.z() / 2, box.size_m.norm() / 2};
               },
               [](const CylinderShape& cylinder) -> Extent {
                 return {cylinder.radius_m, cylinder.height_m / 2,
                         std::hypot(cylinder.radius_m, cylinder.height_m / 2)};
               },
               [](const DiscShape& disc) -> Extent {
                 return {disc.radius_m, disc.radius_m, disc.radius_m};
               }},
      shape);
}

/// The keys around a time, and which share of the way from the one to the other is done: the first twice
/// before it, the last twice after it.
template <typename Key>
std::tuple<const Key&, const Key&, double> around(const std::vector<Key>& keys, double time_s) {
  const auto after = std::upper_bound(keys.begin(), keys.end(), time_s,
                                      [](double time, const Key& key) { return time < key.time_s; });
  if (after == keys.begin()) return {keys.front(), keys.front(), 0.0};
  if (after == keys.end()) return {keys.back(), keys.back(), 0.0};
  const Key& before = *(after - 1);
  return {before, *after, (time_s - before.time_s) / (after->time_s - before.time_s)};
}

constexpr int max_bounces = 10000;

/// Time (s) after which a way (m) is done that begins at `speed` and slows down by `friction`; infinite where
/// it stands before.
double time_for(double way, double speed, double friction) {
  if (friction <= 0) return speed > 0 ? way / speed : infinite;
  const double under_root = speed * speed - 2 * friction * way;
  if (under_root < 0) return infinite;
  return 2 * way / (speed + std::sqrt(under_root));
}

}  // namespace

Material painted_ball(const Rgb& color) {
  Material material;
  material.texture.color = color;
  material.specular = 0.30;
  material.shininess = 40;
  return material;
}

Rgb planckian_rgb(double temperature_k) {
  const double t = temperature_k, t2 = t * t, t3 = t2 * t;
  const double x = t <= 4000 ? -0.2661239e9 / t3 - 0.2343589e6 / t2 + 0.8776956e3 / t + 0.179910
                             : -3.0258469e9 / t3 + 2.1070379e6 / t2 + 0.2226347e3 / t + 0.240390;
  const double x2 = x * x, x3 = x2 * x;
  const double y = t <= 2222   ? -1.1063814 * x3 - 1.34811020 * x2 + 2.18555832 * x - 0.20219683
                   : t <= 4000 ? -0.9549476 * x3 - 1.37418593 * x2 + 2.09137015 * x - 0.16748867
                               : 3.0817580 * x3 - 5.87338670 * x2 + 3.75112997 * x - 0.37001483;
  const Eigen::Vector3d xyz(x / y, 1.0, (1.0 - x - y) / y);
  Eigen::Matrix3d rgb_from_xyz;
  rgb_from_xyz << 3.2404542, -1.5371385, -0.4985314,  //
      -0.9692660, 1.8760108, 0.0415560,               //
      0.0556434, -0.2040259, 1.0572252;
  return (rgb_from_xyz * xyz).cwiseMax(0.0);
}

Rgb LightCourse::gain(double time_s) const {
  if (keys.empty()) return Rgb::Ones();
  const auto [before, after, share] = around(keys, time_s);
  const double temperature_k = before.temperature_k + share * (after.temperature_k - before.temperature_k);
  const double level = before.level + share * (after.level - before.level);
  return level * planckian_rgb(temperature_k).cwiseQuotient(planckian_rgb(white_balance_k));
}

Eigen::Vector2d RollingMotion::place(const Eigen::Vector2d& start_m, double time_s) const {
  Eigen::Vector2d p = start_m, v = velocity_mps;
  double left_s = time_s - start_s;
  for (int bounce = 0; bounce < max_bounces && left_s > 0; ++bounce) {
    const double speed = v.norm();
    if (!(speed > 1e-9)) return p;
    const Eigen::Vector2d along = v / speed;
    double way_m = infinite;
    int axis = 0;
    for (int k = 0; k < 2; ++k) {
      if (along[k] == 0) continue;
      const double to_wall_m = std::max(0.0, ((along[k] > 0 ? high_m : low_m)[k] - p[k]) / along[k]);
      if (to_wall_m < way_m) {
        way_m = to_wall_m;
        axis = k;
      }
    }
    const double wall_s = time_for(way_m, speed, friction_mps2);
    const double stands_s = friction_mps2 > 0 ? speed / friction_mps2 : infinite;
    const double step_s = std::min({left_s, wall_s, stands_s});
    p += along * (speed * step_s - 0.5 * friction_mps2 * step_s * step_s);
    if (!(wall_s <= left_s && wall_s <= stands_s)) return p;
    v = along * (speed - friction_mps2 * step_s);
    v[axis] *= -restitution;
    left_s -= step_s;
  }
  return p;
}

Eigen::Vector3d Ball::p_WB(double time_s) const {
  return std::visit(
      Overload{[&](const StaticMotion&) -> Eigen::Vector3d { return position_m; },
               [&](const LinearMotion& linear) -> Eigen::Vector3d {
                 const double moved_s = std::clamp(time_s - linear.start_s, 0.0, linear.duration_s);
                 return position_m +
                        Eigen::Vector3d(linear.velocity_mps.x(), linear.velocity_mps.y(), 0) * moved_s;
               },
               [&](const CircleMotion& circle) -> Eigen::Vector3d {
                 const double angle = circle.rate_radps * time_s, c = std::cos(angle), s = std::sin(angle);
                 const Eigen::Vector2d arm = position_m.head<2>() - circle.center_m;
                 return {circle.center_m.x() + c * arm.x() - s * arm.y(),
                         circle.center_m.y() + s * arm.x() + c * arm.y(), position_m.z()};
               },
               [&](const RollingMotion& rolling) -> Eigen::Vector3d {
                 const Eigen::Vector2d place_m = rolling.place(position_m.head<2>(), time_s);
                 return {place_m.x(), place_m.y(), position_m.z()};
               },
               [&](const WaypointMotion& way) -> Eigen::Vector3d {
                 const auto [before, after, share] = around(way.points, time_s);
                 return before.position_m + share * (after.position_m - before.position_m);
               }},
      motion);
}

std::pair<double, double> Ball::heights_m() const {
  std::pair<double, double> heights(position_m.z(), position_m.z());
  if (const auto* way = std::get_if<WaypointMotion>(&motion)) {
    for (const WaypointMotion::Point& point : way->points) {
      heights.first = std::min(heights.first, point.position_m.z());
      heights.second = std::max(heights.second, point.position_m.z());
    }
  }
  return heights;
}

double Obstacle::bottom_m() const { return center_m.z() - extent_of(shape).half_height_m; }
double Obstacle::top_m() const { return center_m.z() + extent_of(shape).half_height_m; }
double Obstacle::outline_radius_m() const { return extent_of(shape).outline_radius_m; }
double Obstacle::bounding_radius_m() const { return extent_of(shape).bounding_radius_m; }

bool looks_alike(const World& world, double time_s, double other_s) {
  const auto still = [&](const Ball& ball) { return ball.p_WB(time_s) == ball.p_WB(other_s); };
  const auto steady = [&](const auto& light) {
    return light.course.gain(time_s) == light.course.gain(other_s);
  };
  return std::all_of(world.balls.begin(), world.balls.end(), still) &&
         std::all_of(world.lights.begin(), world.lights.end(), steady) &&
         std::all_of(world.changing_ambient.begin(), world.changing_ambient.end(), steady);
}

FloorOutline floor_outline(const Obstacle& obstacle) {
  const Eigen::Vector2d center = obstacle.center_m.head<2>();
  if (const auto* cylinder = std::get_if<CylinderShape>(&obstacle.shape))
    return {{center}, cylinder->radius_m};
  Eigen::Vector2d half;
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape)) {
    half = box->size_m.head<2>() / 2;
  } else {
    half = {disc_half_thickness_m, std::get<DiscShape>(obstacle.shape).radius_m};
  }
  const Eigen::Vector2d ahead(std::cos(obstacle.yaw_rad), std::sin(obstacle.yaw_rad));
  const Eigen::Vector2d left(-ahead.y(), ahead.x());
  return {{center + half.x() * ahead - half.y() * left, center + half.x() * ahead + half.y() * left,
           center - half.x() * ahead + half.y() * left, center - half.x() * ahead - half.y() * left},
          0.0};
}

double FloorOutline::distance_m(const Eigen::Vector2d& p) const {
  if (radius_m > 0) return std::max(0.0, (p - points_m.front()).norm() - radius_m);
  bool inside = true;
  double nearest_m = infinite;
  for (std::size_t k = 0; k < points_m.size(); ++k) {
    const Eigen::Vector2d along = points_m[(k + 1) % points_m.size()] - points_m[k], away = p - points_m[k];
    if (cross(along, away) < 0) inside = false;
    const double share = std::clamp(away.dot(along) / std::max(along.squaredNorm(), 1e-300), 0.0, 1.0);
    nearest_m = std::min(nearest_m, (away - share * along).norm());
  }
  return inside ? 0.0 : nearest_m;
}

}  // namespace ballservo
