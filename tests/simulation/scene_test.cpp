// Four rays at once against one at a time.
#include "servo/simulation/rendering/scene.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

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
  return world;
}

Eigen::Vector3d random_direction(RandomEngine& engine) {
  const double z = uniform(engine, -1, 1), angle = uniform(engine, 0, 2 * M_PI), r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

TEST(Scene, FourRaysMeetTheRoomWhereEachDoes) {
  const Scene scene(room_of(Pattern::plain), 0);
  RandomEngine engine = random_stream(1, "scene_test");
  const Eigen::Vector3d origin(1.0, -0.5, 0.3);
  for (int n = 0; n < 2000; ++n) {
    Triple4 rays{};
    std::array<Eigen::Vector3d, 4> directions;
    for (int k = 0; k < 4; ++k) {
      Eigen::Vector3d d = random_direction(engine);
      if (n < 3) d = Eigen::Vector3d::Unit((n + k) % 3) * (k < 2 ? 1 : -1);  // along the axes
      directions[static_cast<std::size_t>(k)] = d;
      rays.x[k] = static_cast<float>(d.x());
      rays.y[k] = static_cast<float>(d.y());
      rays.z[k] = static_cast<float>(d.z());
    }
    const RoomHits hits = scene.hit_room(origin, rays);
    for (int k = 0; k < 4; ++k) {
      const SurfaceHit hit = scene.hit_surface(origin, directions[static_cast<std::size_t>(k)], {});
      EXPECT_EQ(hits.surface[k], hit.surface);
      EXPECT_NEAR(hits.t[k], hit.t, 1e-5 * hit.t);
    }
  }
}

/// By the lamps themselves, without a light map, in double precision but for the texture.
TEST(Scene, FourPointsAreShadedAsEachIsByTheLampsThemselves) {
  for (const Pattern pattern : all_patterns) {
    const World world = room_of(pattern);
    const LightMap light_map(world);
    const Scene mapped(world, 0, &light_map), plain(world, 0);
    RandomEngine engine = random_stream(2, "scene_test");
    const Eigen::Vector3d origin(1.0, -0.5, 0.3);
    int shaded = 0, beside_a_ball = 0;
    for (int n = 0; n < 4000; ++n) {
      const Eigen::Vector3d first = random_direction(engine);
      Triple4 rays{};
      std::array<SurfaceHit, 4> hits;
      std::array<Eigen::Vector3d, 4> directions;
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector3d d = (first + 0.03 * k * Eigen::Vector3d(0.3, -0.5, 0.4)).normalized();
        hits[static_cast<std::size_t>(k)] = plain.hit_surface(origin, d, {});
        directions[static_cast<std::size_t>(k)] = d;
        rays.x[k] = static_cast<float>(d.x());
        rays.y[k] = static_cast<float>(d.y());
        rays.z[k] = static_cast<float>(d.z());
      }
      const RoomHits room_hits = mapped.hit_room(origin, rays);
      const int surface = hits[0].surface;
      if (!all(room_hits.surface == surface)) continue;
      Triple4 colors{};
      if (!mapped.shade_room(surface, room_hits.t, origin, rays, 0.002, colors)) {
        ++beside_a_ball;
        continue;
      }
      ++shaded;
      for (std::size_t k = 0; k < 4; ++k) {
        const Rgb expected = plain.shade_surface(hits[k], origin, directions[k], 0.002);
        const int i = static_cast<int>(k);
        const Rgb color(colors.x[i], colors.y[i], colors.z[i]);
        EXPECT_LT((color - expected).cwiseAbs().maxCoeff(), 0.012 * (0.1 + expected.maxCoeff()))
            << pattern_name(pattern) << " " << surface;
      }
    }
    EXPECT_GT(shaded, 2000);
    EXPECT_GT(beside_a_ball, 5);
  }
}

}  // namespace
}  // namespace ballservo
