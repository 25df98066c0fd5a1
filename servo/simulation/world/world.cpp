#include "servo/simulation/world/world.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

template <typename... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};
template <typename... Cases>
Overload(Cases...) -> Overload<Cases...>;

/// Half the thickness of a disc seen from above: enough to have an outline (m).
constexpr double disc_half_thickness_m = 0.002;

double half_height_m(const Shape& shape) {
  return std::visit(Overload{[](const BoxShape& box) { return box.size_m.z() / 2; },
                             [](const CylinderShape& cylinder) { return cylinder.height_m / 2; },
                             [](const DiscShape& disc) { return disc.radius_m; }},
                    shape);
}

}  // namespace

Material painted_ball(const Rgb& color) {
  Material material;
  material.texture.color = color;
  material.specular = 0.30;
  material.shininess = 40;
  return material;
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
                 const auto after = std::upper_bound(
                     way.points.begin(), way.points.end(), time_s,
                     [](double time, const WaypointMotion::Point& point) { return time < point.time_s; });
                 if (after == way.points.begin()) return way.points.front().position_m;
                 const auto before = after - 1;
                 if (after == way.points.end()) return before->position_m;
                 const double share = (time_s - before->time_s) / (after->time_s - before->time_s);
                 return before->position_m + share * (after->position_m - before->position_m);
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

double Obstacle::bottom_m() const { return center_m.z() - half_height_m(shape); }
double Obstacle::top_m() const { return center_m.z() + half_height_m(shape); }

double Obstacle::outline_radius_m() const {
  return std::visit(Overload{[](const BoxShape& box) { return box.size_m.head<2>().norm() / 2; },
                             [](const CylinderShape& cylinder) { return cylinder.radius_m; },
                             [](const DiscShape& disc) { return disc.radius_m; }},
                    shape);
}

double Obstacle::bounding_radius_m() const {
  return std::visit(Overload{[](const BoxShape& box) { return box.size_m.norm() / 2; },
                             [](const CylinderShape& cylinder) {
                               return std::hypot(cylinder.radius_m, cylinder.height_m / 2);
                             },
                             [](const DiscShape& disc) { return disc.radius_m; }},
                    shape);
}

const Ball* World::find_ball(const std::string& name) const {
  const auto found =
      std::find_if(balls.begin(), balls.end(), [&](const Ball& ball) { return ball.name == name; });
  return found == balls.end() ? nullptr : &*found;
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

}  // namespace ballservo
