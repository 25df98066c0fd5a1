#include "servo/simulation/rendering/scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {

namespace {

constexpr double openness_radii = 8;  // within which a ball keeps off light from everywhere

constexpr std::size_t shadow_samples = 24;  // of a lamp's disc, for shadows of solids

/// Fraction of a disc of radius a that a disc of radius b at a distance covers (all small angles).
Floats covered_fraction(Floats a, Floats b, Floats distance) {
  const Floats a2 = a * a, b2 = b * b, d2 = distance * distance;
  // What an arc cuts off a disc: half the angle at its middle less the triangle, by that angle's cosine.
  const auto segment = [](Floats cosine) {
    const Floats x = max(min(cosine, spread(1.0f)), spread(-1.0f));
    const Floats y = square_root(1.0f - x * x);
    return angle_of(y, x) - x * y;
  };
  const Floats least = spread(1e-9f), apart = max(distance, least);
  const Floats area =
      a2 * segment((d2 + a2 - b2) / (2 * apart * a)) + b2 * segment((d2 + b2 - a2) / (2 * apart * b));
  return distance <= abs(b - a) ? min(b2 / a2, spread(1.0f)) : min(area / (3.14159265f * a2), spread(1.0f));
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
Floats corner_light(Floats distance) { return 1.0f - 0.28f / (1.0f + 25.0f * distance * distance); }

Floats dot(const Triples& a, const Triples& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Triples difference(const Triples& a, const Triples& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

/// What of the light from everywhere comes to points of a surface of the room.
Floats room_openness(const Room& room, int surface, const Triples& p) {
  const auto between = [](Floats x, double low, double high) {
    return min(x - static_cast<float>(low), static_cast<float>(high) - x);
  };
  return corner_light(surface >= floor_face ? min(between(p.x, room.x_min_m, room.x_max_m),
                                                  between(p.y, room.y_min_m, room.y_max_m))
                                            : between(p.z, 0, room.height_m));
}

/// The sides of the patches that pixels see of a surface: longer in the direction of view, the flatter the
/// rays meet it. `across_m`: how wide the pixels are there; the rest: the direction's parts along the normal
/// and along the surface's axes.
Pairs seen_patches(Floats across_m, Floats along_normal, Floats along_u, Floats along_v) {
  const Floats stretch = 1.0f / max(abs(along_normal), spread(1e-3f)) - 1.0f;
  const Floats per_flat2 = stretch / max(along_u * along_u + along_v * along_v, spread(1e-12f));
  return {across_m * (1.0f + per_flat2 * along_u * along_u),
          across_m * (1.0f + per_flat2 * along_v * along_v)};
}

}  // namespace

Scene::Scene(const World& world, double time_s, const LightMap* light_map)
    : room_(world.room), lights_(world.lights), ambient_(world.ambient), light_map_(light_map) {
  if (light_map != nullptr) course_gains_ = light_map->gains(time_s);
  for (Light& light : lights_) light.intensity = light.intensity.cwiseProduct(light.course.gain(time_s));
  for (const AmbientLight& light : world.changing_ambient)
    ambient_ += light.intensity.cwiseProduct(light.course.gain(time_s));
  for (const Ball& ball : world.balls) balls_.push_back({ball.p_WB(time_s), ball.radius_m(), ball.material});
  for (const Obstacle& obstacle : world.obstacles) solids_.push_back(scene_solid(obstacle));
  for (const Light& light : lights_) {
    for (const SceneBall& ball : balls_) {
      const Eigen::Vector3d to_ball = ball.center - light.position_m;
      const double ball_m = to_ball.norm();
      shade_cones_.push_back({light.position_m.cast<float>(), (to_ball / ball_m).cast<float>(),
                              static_cast<float>(ball_m), static_cast<float>(ball_m - ball.radius),
                              static_cast<float>(1.05 * ball.radius),
                              static_cast<float>((ball.radius + light.radius_m) / ball_m)});
    }
  }
}

double Scene::hit_solids(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                         double t_max) const {
  double nearest = t_max;
  for (const SceneSolid& solid : solids_) nearest = std::min(nearest, hit_solid(solid, origin, direction));
  return nearest;
}

Floats Scene::share_past_balls(const Light& light, const Triples& p, int own_ball) const {
  const Triples to_lamp = difference(spread(light.position_m), p);
  const Floats square = max(dot(to_lamp, to_lamp), spread(1e-4f)), distance = square_root(square);
  const auto lamp_radius = static_cast<float>(light.radius_m);
  Floats visible = spread(1.0f);
  for (std::size_t k = 0; k < balls_.size(); ++k) {
    if (static_cast<int>(k) == own_ball) continue;
    const auto radius = static_cast<float>(balls_[k].radius);
    const Triples away = difference(spread(balls_[k].center), p);
    const Floats away2 = dot(away, away), along = dot(away, to_lamp) / distance;
    const Floats across2 = max(away2 - along * along, spread(0.0f));
    // The ball touches a ray to the lamp's rim.
    const Floats reach = radius * square_root(square + lamp_radius * lamp_radius) + along * lamp_radius;
    const Ints before = (along > -radius) & (along <= distance) & (across2 * square < reach * reach);
    if (!any(before)) continue;
    const Floats covered =
        covered_fraction(max(angle_of(spread(lamp_radius), distance), spread(1e-4f)),
                         angle_of(spread(radius), square_root(max(away2 - radius * radius, spread(0.0f)))),
                         angle_of(square_root(across2), along));
    visible *= before ? 1.0f - covered : spread(1.0f);
  }
  return visible;
}

double Scene::share_past_solids(const Light& light, const Eigen::Vector3d& p, const Eigen::Vector3d& to_light,
                                double distance, int own_solid) const {
  double visible = 1.0;
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
    for (const Eigen::Vector2d& sample : disc_samples<shadow_samples>()) {
      const Eigen::Vector3d ray =
          to_light * distance + light.radius_m * (sample.x() * side + sample.y() * other);
      if (hit_solid(solid, p, ray) >= 1.0) ++lit;
    }
    visible *= static_cast<double>(lit) / shadow_samples;
  }
  return visible;
}

std::optional<Scene::LampLight> Scene::lamp_light(const Light& light, const Eigen::Vector3d& p,
                                                  const Eigen::Vector3d& normal, int own_ball,
                                                  int own_solid) const {
  const Eigen::Vector3d offset = light.position_m - p;
  const double square = std::max(offset.squaredNorm(), 1e-4), distance = std::sqrt(square);
  const Eigen::Vector3d to_light = offset / distance;
  const double facing = normal.dot(to_light);
  if (facing <= 0.0) return std::nullopt;
  const double past_solids = share_past_solids(light, p, to_light, distance, own_solid);
  if (past_solids <= 0.0) return std::nullopt;
  return LampLight{to_light, facing, past_solids,
                   static_cast<double>(share_past_balls(light, spread(p), own_ball)[0]), square};
}

Rgb Scene::reflected(const Material& material, const Rgb& albedo, const Eigen::Vector3d& p,
                     const Eigen::Vector3d& normal, const Eigen::Vector3d& to_viewer, const Rgb& ambient,
                     int own_ball, int own_solid) const {
  Rgb diffuse = ambient, highlight = Rgb::Zero();
  for (const Light& light : lights_) {
    const auto lamp = lamp_light(light, p, normal, own_ball, own_solid);
    if (!lamp) continue;
    const Rgb arriving = light.intensity * (lamp->past_solids * lamp->past_balls / lamp->square_m2);
    diffuse += arriving * lamp->facing;
    if (material.specular > 0.0) {
      const double half = normal.dot((lamp->to_light + to_viewer).normalized());
      if (half > 0.0) highlight += arriving * std::pow(half, material.shininess);
    }
  }
  return albedo.cwiseProduct(diffuse) + material.specular * highlight;
}

double Scene::lamp_share(const Light& lamp, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                         int own_solid) const {
  const auto light = lamp_light(lamp, p, normal, -1, own_solid);
  return light ? light->facing * light->past_solids * light->past_balls / light->square_m2 : 0.0;
}

Triples Scene::lamp_light_kept_off(int surface, const Ints& points_on_it, const Triples& p,
                                   const Triples& normal) const {
  Triples kept_off{spread(0.0f), spread(0.0f), spread(0.0f)};
  for (const Light& light : lights_) {
    const Floats past_balls = share_past_balls(light, p, -1);
    const Ints shaded = (past_balls < 1.0f) & points_on_it;
    if (!any(shaded)) continue;
    const Triples to_lamp = difference(spread(light.position_m), p);
    const Floats square = max(dot(to_lamp, to_lamp), spread(1e-4f)), distance = square_root(square);
    const Floats facing = dot(normal, to_lamp) / distance;
    Floats share = max(facing, spread(0.0f)) * (1.0f - past_balls) / square;
    for (int k = 0; k < lanes; ++k) {
      share[k] *= shaded[k] == 0
                      ? 0.0f
                      : static_cast<float>(share_past_solids(
                            light, {p.x[k], p.y[k], p.z[k]},
                            Eigen::Vector3d(to_lamp.x[k], to_lamp.y[k], to_lamp.z[k]) / distance[k],
                            distance[k], solid_of(surface)));
    }
    kept_off.x += share * static_cast<float>(light.intensity[0]);
    kept_off.y += share * static_cast<float>(light.intensity[1]);
    kept_off.z += share * static_cast<float>(light.intensity[2]);
  }
  return kept_off;
}

bool Scene::ball_may_shade(const Eigen::AlignedBox3f& box) const {
  const Eigen::Vector3f center = box.center();
  const float radius = 0.5f * box.diagonal().norm();
  const bool behind_one = std::any_of(shade_cones_.begin(), shade_cones_.end(), [&](const ShadeCone& cone) {
    const Eigen::Vector3f away = center - cone.lamp;
    const float along = away.dot(cone.axis), furthest = along + radius;
    const float reach = cone.radius + std::max(furthest - cone.ball_m, 0.0f) * cone.growth;
    return !(furthest < cone.from_m || (away - along * cone.axis).norm() - radius > reach);
  });
  return behind_one || std::any_of(balls_.begin(), balls_.end(), [&](const SceneBall& ball) {
           const double reach = openness_radii * ball.radius + static_cast<double>(radius);
           return !((ball.center - center.cast<double>()).norm() > reach);
         });
}

/// A ball keeps off the light that comes from everywhere (Lambert's cosine over the small disc that it
/// covers).
Floats Scene::openness_beside_balls(const Triples& p, const Triples& normal) const {
  Floats open = spread(1.0f);
  for (const SceneBall& ball : balls_) {
    const Triples away = difference(spread(ball.center), p);
    const auto radius2 = static_cast<float>(ball.radius * ball.radius);
    const Floats square = max(dot(away, away), spread(radius2));
    const Ints near = square <= static_cast<float>(openness_radii * openness_radii) * radius2;
    if (!any(near)) continue;
    const Floats covered = max(dot(normal, away), spread(0.0f)) / square_root(square) * radius2 / square;
    open *= near ? 1.0f - min(covered, spread(1.0f)) : spread(1.0f);
  }
  return open;
}

const Material& Scene::material_of(int surface) const {
  if (surface >= 8) return solids_[static_cast<std::size_t>(solid_of(surface))].material;
  return surface == floor_face ? room_.floor : surface == ceiling_face ? room_.ceiling : room_.wall;
}

bool Scene::light_is_mapped(int surface) const {
  return light_map_ != nullptr && is_plainly_lit(material_of(surface));
}

BALLSERVO_WIDE SurfaceHits Scene::hit_surfaces(const Eigen::Vector3d& origin, const Triples& directions,
                                               const std::vector<int>& candidates) const {
  const auto leave = [](Floats direction, double low_m, double high_m) {
    return (direction > 0.0f ? spread(high_m) : spread(low_m)) / abs(direction);
  };
  const Floats tx = leave(directions.x, origin.x() - room_.x_min_m, room_.x_max_m - origin.x());
  const Floats ty = leave(directions.y, origin.y() - room_.y_min_m, room_.y_max_m - origin.y());
  const Floats tz = leave(directions.z, origin.z(), room_.height_m - origin.z());
  SurfaceHits hits;
  hits.t = min(min(tx, ty), tz);
  const Ints zero{};
  const auto side = [&](Floats direction, int axis) { return zero + 2 * axis - (direction > 0.0f); };
  hits.surface =
      hits.t == tz ? side(directions.z, 2) : (hits.t == tx ? side(directions.x, 0) : side(directions.y, 1));
  for (const int k : candidates) hit_solid(solids_[static_cast<std::size_t>(k)], k, origin, directions, hits);
  return hits;
}

SurfacePoints Scene::points_of(int surface, const Floats& t, const Eigen::Vector3d& origin,
                               const Triples& directions) const {
  if (surface >= 8)
    return points_of_face(solids_[static_cast<std::size_t>(solid_of(surface))], surface % 8, origin, t,
                          directions);
  const FacePlane plane = face_plane(surface);
  const Floats ways[] = {directions.x, directions.y, directions.z};
  const auto place = [&](int axis) { return static_cast<float>(origin[axis]) + t * ways[axis]; };
  const Eigen::Vector3d normal = -plane.sign * Eigen::Vector3d::Unit(plane.axis);
  return {{place(plane.u), place(plane.v)}, ways[plane.axis], ways[plane.u], ways[plane.v], spread(normal)};
}

Triples Scene::shade_mapped(int surface, const Ints& points_on_it, const Floats& t,
                            const Eigen::Vector3d& origin, const Triples& directions, const Triples& p,
                            double pixel_rad, bool beside_ball) const {
  const SurfacePoints points = points_of(surface, t, origin, directions);
  const Pairs patch_m =
      seen_patches(t * static_cast<float>(pixel_rad), points.along_normal, points.along_u, points.along_v);
  const Triples albedo = texture_colors(material_of(surface).texture, points.uv_m, patch_m);
  const Triples ambient = spread(ambient_);
  Triples lamps = light_map_->light(surface, points.uv_m, course_gains_);
  Floats openness = surface < 8 ? room_openness(room_, surface, p) : spread(1.0f);
  if (beside_ball) {
    openness *= openness_beside_balls(p, points.normal);
    // The map lies between its points: what is kept off may be a little more than it knows of.
    const Triples dark = difference(lamps, lamp_light_kept_off(surface, points_on_it, p, points.normal));
    lamps = {max(dark.x, spread(0.0f)), max(dark.y, spread(0.0f)), max(dark.z, spread(0.0f))};
  }
  return {albedo.x * (ambient.x * openness + lamps.x), albedo.y * (ambient.y * openness + lamps.y),
          albedo.z * (ambient.z * openness + lamps.z)};
}

BALLSERVO_WIDE void Scene::shade_surfaces(const SurfaceHits& hits, const Eigen::Vector3d& origin,
                                          const Triples& directions, double pixel_rad, bool beside_ball,
                                          Triples& colors, Ints& shaded) const {
  const Triples o = spread(origin);
  const Triples p{o.x + hits.t * directions.x, o.y + hits.t * directions.y, o.z + hits.t * directions.z};
  Ints rest = hits.t < std::numeric_limits<float>::max();
  shaded = rest;
  while (any(rest)) {
    int first = 0;
    while (rest[first] == 0) ++first;
    const int surface = hits.surface[first];
    const Ints same = rest & (hits.surface == surface);
    rest &= ~same;
    if (!light_is_mapped(surface)) {
      shaded &= ~same;
      continue;
    }
    const Triples shown = shade_mapped(surface, same, hits.t, origin, directions, p, pixel_rad, beside_ball);
    colors = {same ? shown.x : colors.x, same ? shown.y : colors.y, same ? shown.z : colors.z};
  }
}

Rgb Scene::shade_surface(int surface, float t, const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction, double pixel_rad) const {
  const SurfaceHits hits{spread(t), Ints{} + surface};
  const Triples directions = spread(direction);
  const auto first = [](const Triples& v) { return Eigen::Vector3d(v.x[0], v.y[0], v.z[0]); };
  Triples colors;
  Ints shaded;
  shade_surfaces(hits, origin, directions, pixel_rad, true, colors, shaded);
  if (any(shaded)) return first(colors);
  const SurfacePoints points = points_of(surface, hits.t, origin, directions);
  const Pairs patch_m = seen_patches(hits.t * static_cast<float>(pixel_rad), points.along_normal,
                                     points.along_u, points.along_v);
  const Material& material = material_of(surface);
  const Rgb albedo = first(texture_colors(material.texture, points.uv_m, patch_m));
  if (material.luminous) return albedo;

  const Eigen::Vector3d p = origin + static_cast<double>(t) * direction;
  const Floats corner = surface < 8 ? room_openness(room_, surface, spread(p)) : spread(1.0f);
  const auto openness = static_cast<double>((corner * openness_beside_balls(spread(p), points.normal))[0]);
  return reflected(material, albedo, p, first(points.normal), -direction, ambient_ * openness, -1,
                   solid_of(surface));
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
