#include "servo/simulation/scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "servo/simulation/intersection.hpp"
#include "servo/simulation/light_map.hpp"

namespace ballservo {

namespace {

constexpr double pi = 3.14159265358979323846;

/// Points on the unit disc, spread evenly (Vogel, Mathematical Biosciences 1979), for shadows of solids.
constexpr int shadow_samples = 24;

const std::array<Eigen::Vector2d, shadow_samples>& disc_samples() {
  static const std::array<Eigen::Vector2d, shadow_samples> samples = [] {
    std::array<Eigen::Vector2d, shadow_samples> points;
    for (int k = 0; k < shadow_samples; ++k) {
      const double radius = std::sqrt((k + 0.5) / shadow_samples), angle = 2.399963229728653 * k;
      points[static_cast<std::size_t>(k)] = {radius * std::cos(angle), radius * std::sin(angle)};
    }
    return points;
  }();
  return samples;
}

/// Fraction of a disc of radius a that a disc of radius b at a distance covers (all small angles).
double covered_fraction(double a, double b, double distance) {
  if (distance >= a + b) return 0.0;
  if (distance <= std::abs(b - a)) return b >= a ? 1.0 : b * b / (a * a);
  const double a2 = a * a, b2 = b * b, d2 = distance * distance;
  const double alpha = std::acos(std::clamp((d2 + a2 - b2) / (2 * distance * a), -1.0, 1.0));
  const double beta = std::acos(std::clamp((d2 + b2 - a2) / (2 * distance * b), -1.0, 1.0));
  const double area = a2 * (alpha - std::sin(2 * alpha) / 2) + b2 * (beta - std::sin(2 * beta) / 2);
  return std::clamp(area / (pi * a2), 0.0, 1.0);
}

SceneSolid scene_solid(const Obstacle& obstacle) {
  SceneSolid solid;
  solid.center = obstacle.center_m;
  solid.cos_yaw = std::cos(obstacle.yaw_rad);
  solid.sin_yaw = std::sin(obstacle.yaw_rad);
  solid.bounding_radius = obstacle.bounding_radius_m();
  solid.material = obstacle.material;
  if (const auto* box = std::get_if<BoxShape>(&obstacle.shape)) {
    solid.kind = SceneSolid::Kind::box;
    solid.half = box->size_m / 2;
  } else if (const auto* cylinder = std::get_if<CylinderShape>(&obstacle.shape)) {
    solid.kind = SceneSolid::Kind::cylinder;
    solid.half = {cylinder->radius_m, cylinder->radius_m, cylinder->height_m / 2};
  } else {
    const double radius = std::get<DiscShape>(obstacle.shape).radius_m;
    solid.kind = SceneSolid::Kind::disc;
    solid.half = {0, radius, radius};
  }
  return solid;
}

/// Corners get less of the light that comes from everywhere; a smooth stand-in for it.
double corner_light(double distance) { return 1.0 - 0.28 / (1.0 + 25.0 * distance * distance); }

}  // namespace

Scene::Scene(const World& world, double time_s, const LightMap* light_map)
    : room_(world.room), lights_(world.lights), ambient_(world.ambient), light_map_(light_map) {
  for (Light& light : lights_) light.intensity = light.intensity.cwiseProduct(light.course.gain(time_s));
  for (const AmbientLight& light : world.changing_ambient)
    ambient_ += light.intensity.cwiseProduct(light.course.gain(time_s));
  for (const Ball& ball : world.balls) balls_.push_back({ball.p_WB(time_s), ball.radius_m(), ball.material});
  for (const Obstacle& obstacle : world.obstacles) solids_.push_back(scene_solid(obstacle));
}

SurfaceHit Scene::hit_surface(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                              const std::vector<int>& candidates) const {
  SurfaceHit hit;
  // The room is convex and holds the viewer: its nearest plane ahead is the one that the ray leaves through.
  const double tx = direction.x() == 0.0
                        ? no_hit
                        : ((direction.x() > 0 ? room_.x_max_m : room_.x_min_m) - origin.x()) / direction.x();
  const double ty = direction.y() == 0.0
                        ? no_hit
                        : ((direction.y() > 0 ? room_.y_max_m : room_.y_min_m) - origin.y()) / direction.y();
  const double tz = direction.z() == 0.0
                        ? no_hit
                        : ((direction.z() > 0 ? room_.height_m : 0.0) - origin.z()) / direction.z();
  hit.t = std::min({tx, ty, tz});
  int nearest = -1;
  for (const int index : candidates) {
    const double t = hit_solid(solids_[static_cast<std::size_t>(index)], origin, direction);
    if (t < hit.t) {
      hit.t = t;
      nearest = index;
    }
  }
  const Eigen::Vector3d p = origin + hit.t * direction;
  if (nearest >= 0) {
    int face = 0;
    describe_hit(solids_[static_cast<std::size_t>(nearest)], p, direction, hit, face);
    hit.surface = 8 + 8 * nearest + face;
  } else if (hit.t == tz) {
    hit.surface = direction.z() > 0 ? 1 : 0;
    hit.normal = {0, 0, direction.z() > 0 ? -1.0 : 1.0};
    hit.uv_m = p.head<2>();
  } else if (hit.t == tx) {
    hit.surface = direction.x() > 0 ? 3 : 2;
    hit.normal = {direction.x() > 0 ? -1.0 : 1.0, 0, 0};
    hit.uv_m = {p.y(), p.z()};
    hit.u_axis = {0, 1, 0};
    hit.v_axis = {0, 0, 1};
  } else {
    hit.surface = direction.y() > 0 ? 5 : 4;
    hit.normal = {0, direction.y() > 0 ? -1.0 : 1.0, 0};
    hit.uv_m = {p.x(), p.z()};
    hit.u_axis = {1, 0, 0};
    hit.v_axis = {0, 0, 1};
  }
  return hit;
}

double Scene::hit_solids(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         double t_max) const {
  double nearest = t_max;
  for (const SceneSolid& solid : solids_) nearest = std::min(nearest, hit_solid(solid, origin, direction));
  return nearest;
}

double Scene::visible_fraction(const Light& light, const Eigen::Vector3d& p, const Eigen::Vector3d& to_light,
                               double distance, int own_ball, int own_solid) const {
  double visible = 1.0;
  for (std::size_t k = 0; k < balls_.size(); ++k) {
    if (static_cast<int>(k) == own_ball) continue;
    const SceneBall& ball = balls_[k];
    const Eigen::Vector3d away = ball.center - p;
    const double along = away.dot(to_light);
    if (along <= -ball.radius || along > distance) continue;
    const double square = away.squaredNorm(), across2 = square - along * along;
    const double reach = ball.radius + light.radius_m * std::max(along, 0.0) / distance;
    if (across2 >= 4.0 * reach * reach) continue;  // the disc's size grows near the ball: a wide bound
    const double length = std::sqrt(square);
    const double ball_angle = length <= ball.radius ? pi / 2 : std::asin(ball.radius / length);
    const double light_angle = std::max(std::atan2(light.radius_m, distance), 1e-4);
    visible *=
        1.0 - covered_fraction(light_angle, ball_angle, std::atan2(std::sqrt(std::max(across2, 0.0)), along));
  }
  for (std::size_t k = 0; k < solids_.size() && visible > 0.0; ++k) {
    if (static_cast<int>(k) == own_solid) continue;
    const SceneSolid& solid = solids_[k];
    const Eigen::Vector3d away = solid.center - p;
    const double along = away.dot(to_light);
    if (along <= -solid.bounding_radius || along > distance + solid.bounding_radius) continue;
    const double reach = solid.bounding_radius + light.radius_m * std::max(along, 0.0) / distance;
    if (away.squaredNorm() - along * along >= reach * reach) continue;
    if (light.radius_m == 0.0) {
      if (hit_solid(solid, p, to_light) < distance) visible = 0.0;
      continue;
    }
    // Any frame across the ray will do; this one turns smoothly over the floor.
    const Eigen::Vector3d side = Eigen::Vector3d(to_light.z(), 0, -to_light.x()).normalized();
    const Eigen::Vector3d other = to_light.cross(side);
    int lit = 0;
    for (const Eigen::Vector2d& sample : disc_samples()) {
      const Eigen::Vector3d ray =
          to_light * distance + light.radius_m * (sample.x() * side + sample.y() * other);
      if (hit_solid(solid, p, ray) >= 1.0) ++lit;
    }
    visible *= static_cast<double>(lit) / shadow_samples;
  }
  return visible;
}

Rgb Scene::reflected(const Material& material, const Rgb& albedo, const Eigen::Vector3d& p,
                     const Eigen::Vector3d& normal, const Eigen::Vector3d& to_viewer, const Rgb& ambient,
                     int own_ball, int own_solid) const {
  Rgb diffuse = ambient, highlight = Rgb::Zero();
  for (const Light& light : lights_) {
    const Eigen::Vector3d offset = light.position_m - p;
    const double square = std::max(offset.squaredNorm(), 1e-4);
    const double distance = std::sqrt(square);
    const Eigen::Vector3d to_light = offset / distance;
    const double facing = normal.dot(to_light);
    if (facing <= 0.0) continue;
    const double visible = visible_fraction(light, p, to_light, distance, own_ball, own_solid);
    if (visible <= 0.0) continue;
    const Rgb arriving = light.intensity * (visible / square);
    diffuse += arriving * facing;
    if (material.specular > 0.0) {
      const double half = normal.dot((to_light + to_viewer).normalized());
      if (half > 0.0) highlight += arriving * std::pow(half, material.shininess);
    }
  }
  return albedo.cwiseProduct(diffuse) + material.specular * highlight;
}

double Scene::lamp_share(std::size_t lamp, const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const {
  const Light& light = lights_[lamp];
  const Eigen::Vector3d offset = light.position_m - p;
  const double square = std::max(offset.squaredNorm(), 1e-4), distance = std::sqrt(square);
  const Eigen::Vector3d to_light = offset / distance;
  const double facing = normal.dot(to_light);
  return facing <= 0.0 ? 0.0 : facing * visible_fraction(light, p, to_light, distance, -1, -1) / square;
}

/// Whether a ball could keep light of some lamp from a point: the point lies in the ball's cone of half
/// shadow.
bool Scene::shaded_by_ball(const Eigen::Vector3d& p) const {
  for (const Light& light : lights_) {
    const Eigen::Vector3d to_p = p - light.position_m;
    for (const SceneBall& ball : balls_) {
      const Eigen::Vector3d to_ball = ball.center - light.position_m;
      const double square = to_ball.squaredNorm(), along = to_p.dot(to_ball) / square;  // 1: beside the ball
      const double distance = std::sqrt(square);
      if (along * distance < distance - ball.radius) continue;
      const double reach =
          ball.radius + std::max(along - 1, 0.0) * (ball.radius + light.radius_m) + 0.05 * ball.radius;
      if (to_p.squaredNorm() - along * along * square < reach * reach) return true;
    }
  }
  return false;
}

Rgb Scene::shade_surface(const SurfaceHit& hit, const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction, double pixel_rad) const {
  const int own_solid = hit.surface >= 8 ? (hit.surface - 8) / 8 : -1;
  const Material& material = own_solid >= 0     ? solids_[static_cast<std::size_t>(own_solid)].material
                             : hit.surface == 0 ? room_.floor
                             : hit.surface == 1 ? room_.ceiling
                                                : room_.wall;
  // The patch that the pixel sees is longer in the direction of view, the flatter the ray meets the surface.
  const double across = pixel_rad * hit.t;
  const double slant = std::max(std::abs(hit.normal.dot(direction)), 1e-3);
  const Eigen::Vector2d along_uv(direction.dot(hit.u_axis), direction.dot(hit.v_axis));
  const double flat2 = std::max(along_uv.squaredNorm(), 1e-12);
  const double stretch = 1.0 / slant - 1.0;
  const Eigen::Vector2d patch = across * (Eigen::Vector2d::Ones() + stretch * along_uv.cwiseAbs2() / flat2);
  const Rgb albedo = texture_color(material.texture, hit.uv_m, patch);
  if (material.luminous) return albedo;

  const Eigen::Vector3d p = origin + hit.t * direction;
  double openness = 1.0;
  if (hit.surface < 8) {
    const double to_wall = std::min(
        {p.x() - room_.x_min_m, room_.x_max_m - p.x(), p.y() - room_.y_min_m, room_.y_max_m - p.y()});
    openness = corner_light(hit.surface <= 1 ? to_wall : std::min(p.z(), room_.height_m - p.z()));
  }
  // A ball keeps off the light that comes from everywhere (Lambert's cosine over the small disc that it
  // covers).
  for (const SceneBall& ball : balls_) {
    const Eigen::Vector3d away = ball.center - p;
    const double square = std::max(away.squaredNorm(), ball.radius * ball.radius);
    if (square > 64.0 * ball.radius * ball.radius) continue;
    const double covered =
        std::max(hit.normal.dot(away), 0.0) / std::sqrt(square) * ball.radius * ball.radius / square;
    openness *= 1.0 - std::min(covered, 1.0);
  }
  if (hit.surface < 8 && light_map_ != nullptr && material.specular == 0.0 && !shaded_by_ball(p)) {
    return albedo.cwiseProduct(ambient_ * openness + light_map_->light(hit.surface, hit.uv_m, lights_));
  }
  return reflected(material, albedo, p, hit.normal, -direction, ambient_ * openness, -1, own_solid);
}

Rgb Scene::shade_ball(int index, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  const SceneBall& ball = balls_[static_cast<std::size_t>(index)];
  if (ball.material.luminous) return ball.material.texture.color;
  const Eigen::Vector3d from_center = origin - ball.center;
  const double along = -from_center.dot(direction);
  const Eigen::Vector3d nearest = from_center + along * direction;
  const double inside2 = ball.radius * ball.radius - nearest.squaredNorm();
  const Eigen::Vector3d normal =
      (inside2 > 0.0 ? Eigen::Vector3d(nearest - std::sqrt(inside2) * direction) : nearest).normalized();
  const Eigen::Vector3d p = ball.center + ball.radius * normal;
  // From below comes only what the floor sends back, and less of it the nearer the floor.
  const double floor_share = 0.5 * (1.0 - normal.z());
  const double floor_light = 0.45 * std::min(1.0, std::max(p.z(), 0.0) / ball.radius);
  const Rgb ambient = ambient_ * (1.0 - floor_share + floor_share * floor_light);
  return reflected(ball.material, ball.material.texture.color, p, normal, -direction, ambient, index, -1);
}

}  // namespace ballservo
