// Many rays at once against one at a time in double precision.
#include "servo/simulation/rendering/scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

World room_of(Pattern pattern) {
  World world;
  world.room.floor.texture = {pattern, {0.5, 0.36, 0.21}, {0.3, 0.18, 0.09}, 0.12};
  world.room.wall.texture = {pattern, {0.66, 0.65, 0.6}, {0.4, 0.57, 0.2}, 0.6};
  Ball ball;
  ball.diameter_m = 0.12;
  ball.position_m = {2.0, 0.1, 0.06};
  Ball in_the_air = ball;
  in_the_air.position_m = {2.5, -0.3, 1.0};
  world.balls = {ball, in_the_air};
  world.lights = {{{1.5, 0.8, 1.8}, {4, 4, 3}, 0.2}, {{3, -0.8, 1.6}, {1, 2, 3}, 0.0}};
  // More than the light map looks up at once.
  for (int k = 0; k < 4; ++k)
    world.lights.push_back({{1 + 0.7 * k, 1.2 - 0.8 * k, 2.0}, {0.3, 0.1 * k, 0.2}, 0.5});
  return world;
}

Eigen::Vector3d random_direction(RandomEngine& engine) {
  const double z = uniform(engine, -1, 1), angle = uniform(engine, 0, 2 * M_PI), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// A box, a cylinder and a disc besides, turned.
World furnished_room_of(Pattern pattern) {
  World world = room_of(pattern);
  Obstacle obstacle;
  obstacle.material.texture = {pattern, {0.3, 0.36, 0.5}, {0.5, 0.2, 0.3}, 0.05};
  obstacle.shape = BoxShape{{0.4, 0.3, 0.5}};
  obstacle.center_m = {2.2, 0.9, 0.25};
  obstacle.yaw_rad = 0.5;
  world.obstacles.push_back(obstacle);
  obstacle.shape = CylinderShape{0.15, 0.4};
  obstacle.center_m = {1.6, -1.3, 0.2};
  world.obstacles.push_back(obstacle);
  obstacle.shape = DiscShape{0.3};
  obstacle.center_m = {0.2, -0.2, 0.4};
  world.obstacles.push_back(obstacle);
  return world;
}

struct ManyRays {
  Triples together{};
  std::array<Eigen::Vector3d, lanes> each;

  void set(int k, const Eigen::Vector3d& d) {
    each[static_cast<std::size_t>(k)] = d;
    together.x[k] = static_cast<float>(d.x());
    together.y[k] = static_cast<float>(d.y());
    together.z[k] = static_cast<float>(d.z());
  }
};

const std::vector<int> all_solids{0, 1, 2};

/// The coordinates of a point that a ray meets lead back to it, by the places that the light map has.
void expect_on_face(const SceneSolid& solid, int face, const SurfacePoints& points, int k,
                    const Eigen::Vector3d& p, const Eigen::Vector3d& direction) {
  constexpr double step = 1e-3;
  const Eigen::Vector2d uv_m(points.uv_m.u[k], points.uv_m.v[k]);
  const Eigen::Vector2d along_m(points.along_u[k], points.along_v[k]);
  const auto [place, normal] = place_on_face(solid, face, uv_m);
  EXPECT_LT((place - p).norm(), 1e-4) << face;
  EXPECT_LT((Eigen::Vector3d(points.normal.x[k], points.normal.y[k], points.normal.z[k]) - normal).norm(),
            1e-4)
      << face;
  EXPECT_NEAR(std::abs(points.along_normal[k]), -normal.dot(direction), 1e-4) << face;
  const Eigen::Vector3d step_on_it = (place_on_face(solid, face, uv_m + step * along_m).first - place) / step;
  EXPECT_LT((step_on_it + normal.dot(direction) * normal - direction).norm(), 0.01) << face;
}

TEST(Scene, ManyRaysMeetWhatEachDoes) {
  const World world = furnished_room_of(Pattern::plain);
  const Scene scene(world, 0);
  RandomEngine engine = random_stream(1, "scene_test");
  const Eigen::Vector3d origin(1.0, -0.5, 0.3), low_m = world.room.low_m(), high_m = world.room.high_m();
  std::set<int> met;
  int beside_an_edge = 0;
  for (int n = 0; n < 4000; ++n) {
    ManyRays rays;
    for (int k = 0; k < lanes; ++k) {
      Eigen::Vector3d d = random_direction(engine);
      if (n < 3) d = Eigen::Vector3d::Unit((n + k) % 3) * (k < lanes / 2 ? 1 : -1);  // along the axes
      if (n % 2 == 1) {                                                              // at a solid
        const Eigen::Vector3d& center_m = world.obstacles[static_cast<std::size_t>(n / 2 % 3)].center_m;
        d = (center_m + 0.35 * d - origin).normalized();
      }
      rays.set(k, d);
    }
    const SurfaceHits hits = scene.hit_surfaces(origin, rays.together, all_solids);
    for (int k = 0; k < lanes; ++k) {
      const Eigen::Vector3d& d = rays.each[static_cast<std::size_t>(k)];
      const int surface = hits.surface[k];
      double t = no_hit;
      int nearest = -1;
      for (int axis = 0; axis < 3; ++axis)
        if (d[axis] != 0) t = std::min(t, ((d[axis] > 0 ? high_m : low_m)[axis] - origin[axis]) / d[axis]);
      for (const int index : all_solids) {
        const double to_solid = hit_solid(scene.solids()[static_cast<std::size_t>(index)], origin, d);
        if (to_solid < t) nearest = index;
        t = std::min(t, to_solid);
      }
      met.insert(surface);
      if (solid_of(surface) != nearest) {
        ++beside_an_edge;
        continue;
      }
      EXPECT_NEAR(hits.t[k], t, 1e-5 * t) << surface;
      const Eigen::Vector3d p = origin + t * d;
      if (nearest >= 0) {
        const SceneSolid& solid = scene.solids()[static_cast<std::size_t>(nearest)];
        const int face = surface % 8;
        expect_on_face(solid, face, points_of_face(solid, face, origin, hits.t, rays.together), k, p, d);
      } else {
        const FacePlane plane = face_plane(surface);
        EXPECT_NEAR(p[plane.axis], (plane.sign > 0 ? high_m : low_m)[plane.axis], 1e-4) << surface;
      }
    }
  }
  EXPECT_LT(beside_an_edge, 5);
  // The room, four faces of the box (it stands on the floor, and two are turned away), the cylinder's side
  // and top, the disc's one side.
  EXPECT_GE(met.size(), 6u + 2u + 1u + 1u);
}

TEST(Scene, TheAngleIsThatOfTheQuadrant) {
  for (double angle = -3.14; angle < 3.14; angle += 0.0137) {
    const Floats found = angle_of(spread(0.3 * std::sin(angle)), spread(0.3 * std::cos(angle)));
    EXPECT_NEAR(found[0], angle, 5e-6);
  }
}

/// Lambert's cosine over the small disc that the ball covers.
TEST(Scene, ABallKeepsOffLightThatComesFromEverywhere) {
  World world;
  world.balls = {Ball{}};
  world.balls[0].diameter_m = 0.12;
  world.balls[0].position_m = {2, 0, 0.06};
  World without = world;
  without.balls.clear();
  const Eigen::Vector3d origin(0, 0, 0.3);
  for (const double beside_m : {0.1, 0.2, 0.4, 0.6}) {
    const Eigen::Vector3d direction = (Eigen::Vector3d(2, beside_m, 0) - origin).normalized();
    const auto light = [&](const World& seen) {
      const Scene scene(seen, 0);
      const double t = -origin.z() / direction.z();
      return scene.shade_surface(floor_face, static_cast<float>(t), origin, direction, 0.002).sum();
    };
    const double square = beside_m * beside_m + 0.06 * 0.06;
    const double covered = square > 0.48 * 0.48 ? 0 : 0.06 / std::sqrt(square) * 0.06 * 0.06 / square;
    EXPECT_NEAR(light(world) / light(without), 1 - covered, 1e-4) << beside_m;
  }
}

/// By the lamps themselves, without a light map, in double precision but for place and texture.
TEST(Scene, ManyPointsAreShadedAsEachIsByTheLampsThemselves) {
  for (const Pattern pattern : all_patterns) {
    const World world = furnished_room_of(pattern);
    const LightMap light_map(world);
    World empty = world;
    empty.balls.clear();
    const Scene mapped(world, 0, &light_map), plain(world, 0), without(empty, 0);
    RandomEngine engine = random_stream(2, "scene_test");
    const Eigen::Vector3d origin(1.0, -0.5, 0.3);
    int on_room = 0, on_solids = 0, behind_a_ball = 0, off_room = 0, off_solids = 0;
    for (int n = 0; n < 4000; ++n) {
      Eigen::Vector3d first = random_direction(engine);
      if (n % 2 == 1)
        first = (world.obstacles[static_cast<std::size_t>(n / 2 % 3)].center_m + 0.3 * first - origin)
                    .normalized();
      ManyRays rays;
      for (int k = 0; k < lanes; ++k)
        rays.set(k, (first + 0.02 * k * Eigen::Vector3d(0.3, -0.5, 0.4)).normalized());
      const SurfaceHits hits = mapped.hit_surfaces(origin, rays.together, all_solids);
      Triples colors{};
      Ints shaded;
      mapped.shade_surfaces(hits, origin, rays.together, 0.002, true, colors, shaded);
      for (int k = 0; k < lanes; ++k) {
        const Eigen::Vector3d& direction = rays.each[static_cast<std::size_t>(k)];
        const int surface = hits.surface[k];
        ++(surface < 8 ? on_room : on_solids);
        const Rgb expected = plain.shade_surface(surface, hits.t[k], origin, direction, 0.002);
        if (expected.sum() < 0.9 * without.shade_surface(surface, hits.t[k], origin, direction, 0.002).sum())
          ++behind_a_ball;
        const Rgb color(colors.x[k], colors.y[k], colors.z[k]);
        if ((color - expected).cwiseAbs().maxCoeff() > 0.012 * (0.1 + expected.maxCoeff()))
          ++(surface < 8 ? off_room : off_solids);
      }
    }
    EXPECT_GT(on_room, 10000);
    EXPECT_GT(on_solids, 3000);
    EXPECT_GT(behind_a_ball, 5);
    // The map blurs sharp shadows, and the feet of what stands there, over one of its cells.
    EXPECT_LT(off_room, 0.015 * on_room) << pattern_name(pattern);
    EXPECT_LT(off_solids, 0.01 * on_solids) << pattern_name(pattern);
  }
}

}  // namespace
}  // namespace ballservo
