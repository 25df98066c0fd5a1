#include "servo/simulation/robot/sonar_ring.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

constexpr double degree = 0.017453292519943295;

Obstacle thing(const Shape& shape, const Eigen::Vector3d& center, double yaw_rad = 0) {
  Obstacle obstacle;
  obstacle.name = "thing";
  obstacle.shape = shape;
  obstacle.center_m = center;
  obstacle.yaw_rad = yaw_rad;
  return obstacle;
}

World empty_room() { return test::dark_room(); }

SonarOptions quiet() {
  SonarOptions options;
  options.noise_sigma_m = 0;
  return options;
}

std::vector<SonarReading> listen(SonarRing& ring, const Pose2& pose, int firings) {
  std::vector<SonarReading> heard;
  for (int k = 0; k < firings; ++k) {
    ring.fire(pose);
    ring.deliver(ring.next_s() + 10, [&](const SonarReading& reading) { heard.push_back(reading); });
  }
  return heard;
}

/// The nearest point of the world's obstacles and walls in the cone, by looking along many rays.
double range_by_rays(const World& world, const Pose2& pose, const SonarMount& mount, double half_angle_rad) {
  const Eigen::Vector2d apex = in_world_frame(pose, {mount.x_m, mount.y_m});
  const double heading = pose.yaw_rad + mount.heading_rad;
  double nearest = 1e9;
  for (int k = -400; k <= 400; ++k) {
    const double angle = heading + half_angle_rad * k / 400.0;
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const auto edge = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
      const Eigen::Vector2d along = b - a, away = a - apex;
      const double det = along.x() * ray.y() - along.y() * ray.x();
      if (std::abs(det) < 1e-12) return;
      const double t = (along.x() * away.y() - along.y() * away.x()) / det;
      const double s = (ray.x() * away.y() - ray.y() * away.x()) / det;
      if (t > 0 && s >= 0 && s <= 1) nearest = std::min(nearest, t);
    };
    const Room& room = world.room;
    edge({room.x_min_m, room.y_min_m}, {room.x_max_m, room.y_min_m});
    edge({room.x_max_m, room.y_min_m}, {room.x_max_m, room.y_max_m});
    edge({room.x_max_m, room.y_max_m}, {room.x_min_m, room.y_max_m});
    edge({room.x_min_m, room.y_max_m}, {room.x_min_m, room.y_min_m});
    for (const Obstacle& obstacle : world.obstacles) {
      const FloorOutline outline = floor_outline(obstacle);
      if (outline.radius_m > 0) {
        const Eigen::Vector2d c = outline.points_m[0] - apex;
        const double ahead = c.dot(ray), aside2 = c.squaredNorm() - ahead * ahead;
        if (ahead > 0 && aside2 < outline.radius_m * outline.radius_m) {
          nearest = std::min(nearest, ahead - std::sqrt(outline.radius_m * outline.radius_m - aside2));
        }
        continue;
      }
      for (std::size_t i = 0; i < outline.points_m.size(); ++i) {
        edge(outline.points_m[i], outline.points_m[(i + 1) % outline.points_m.size()]);
      }
    }
  }
  return nearest;
}

TEST(SonarRing, HearsTheNearestPointInItsCone) {
  RandomEngine engine = random_stream(1, "sonar test");
  for (int world_number = 0; world_number < 60; ++world_number) {
    World world = empty_room();
    for (int k = 0; k < 4; ++k) {
      const double angle = uniform(engine, -3.1, 3.1), distance = uniform(engine, 1.2, 3.5);
      const Eigen::Vector3d center(distance * std::cos(angle), distance * std::sin(angle), 0.3);
      world.obstacles.push_back(
          k % 2 ? thing(CylinderShape{uniform(engine, 0.03, 0.3), 0.6}, center)
                : thing(BoxShape{{uniform(engine, 0.1, 0.8), uniform(engine, 0.1, 0.8), 0.6}}, center,
                        uniform(engine, 0, 3)));
    }
    const SonarRing ring(world, quiet(), {}, 0);
    const Pose2 pose{uniform(engine, -0.2, 0.2), uniform(engine, -0.2, 0.2), uniform(engine, -3, 3)};
    for (std::size_t k = 0; k < sonar_count; ++k) {
      const double heard = ring.true_range_m(pose, k, 0);
      const double rays = range_by_rays(world, pose, pioneer_3dx_sonars[k], quiet().beam.half_angle_rad);
      // Rays may pass a corner that the cone holds, by less than their spacing.
      EXPECT_LE(heard, rays + 1e-9) << world_number << ' ' << k;
      EXPECT_GE(heard, rays - 0.08 * rays) << world_number << ' ' << k;
    }
  }
}

TEST(SonarRing, EachArrayFiresEveryPeriodAndEachTransducerEveryEight) {
  const World world = empty_room();
  SonarRing ring(world, quiet(), {}, 0);
  const auto heard = listen(ring, {}, 64);
  ASSERT_EQ(heard.size(), 64u);
  std::map<std::size_t, std::vector<double>> times;
  for (std::size_t k = 0; k < heard.size(); ++k) {
    EXPECT_NEAR(heard[k].fired_s, 0.02 * static_cast<double>(k), 1e-12);
    times[heard[k].transducer].push_back(heard[k].fired_s);
  }
  ASSERT_EQ(times.size(), 16u);
  for (const auto& [transducer, fired] : times) {
    for (std::size_t k = 1; k < fired.size(); ++k) EXPECT_NEAR(fired[k] - fired[k - 1], 0.32, 1e-12);
  }
}

TEST(SonarRing, LowAndHangingThingsAndSilentBallsHaveNoEcho) {
  World world = empty_room();
  const SonarMount& mount = pioneer_3dx_sonars[3];
  const auto ahead = [&](double z) {
    return Eigen::Vector3d(mount.x_m + std::cos(mount.heading_rad), mount.y_m + std::sin(mount.heading_rad),
                           z);
  };
  world.obstacles = {thing(BoxShape{{0.3, 0.3, 0.19}}, ahead(0.095)),
                     thing(BoxShape{{0.3, 0.3, 0.1}}, ahead(0.35))};
  Ball ball = test::white_ball(ahead(0.1), 0.2);
  world.balls = {ball};
  EXPECT_GT(SonarRing(world, quiet(), {}, 0).true_range_m({}, 3, 0), 10);
  world.balls[0].sonar = true;
  EXPECT_NEAR(SonarRing(world, quiet(), {}, 0).true_range_m({}, 3, 0), 0.9, 1e-9);
  world.obstacles[0] = thing(BoxShape{{0.1, 0.1, 0.21}}, ahead(0.105), mount.heading_rad);
  world.balls.clear();
  EXPECT_NEAR(SonarRing(world, quiet(), {}, 0).true_range_m({}, 3, 0), 0.95, 1e-9);
}

TEST(SonarRing, SmoothSurfacesAnswerOnlyNearTheirNormal) {
  World world = empty_room();
  SonarOptions options = quiet();
  options.specular_limit_rad = 20 * degree;
  for (const double yaw : {0.0, 0.3, 0.55, 0.7, 1.2}) {
    // A long wall a metre ahead of transducer 3, turned by yaw against it.
    const SonarMount& mount = pioneer_3dx_sonars[3];
    const double angle = mount.heading_rad + yaw;
    world.obstacles = {thing(BoxShape{{0.1, 8, 0.6}},
                             {mount.x_m + std::cos(mount.heading_rad) + 0.05 * std::cos(angle),
                              mount.y_m + std::sin(mount.heading_rad) + 0.05 * std::sin(angle), 0.3},
                             angle)};
    const double range = SonarRing(world, options, {}, 0).true_range_m({}, 3, 0);
    // The nearest point of the cone meets the wall at yaw - 15 degrees from the normal.
    EXPECT_EQ(range < 2, yaw < 35 * degree) << yaw;
  }
}

TEST(SonarRing, NoiseStaysWithinItsBoundAndRangesWithinTheirLimits) {
  World world = empty_room();
  world.obstacles = {thing(CylinderShape{0.3, 0.6}, {1.5, 0, 0.3})};
  SonarOptions options;
  options.noise_sigma_m = 0.01;
  SonarRing ring(world, options, {}, 5);
  double sum2 = 0;
  int count = 0;
  for (const SonarReading& reading : listen(ring, {}, 16000)) {
    const double truth = ring.true_range_m({}, reading.transducer, 0);
    if (truth > 5) {
      EXPECT_EQ(reading.range_m, 5.0);
      EXPECT_FALSE(reading.echo);
      continue;
    }
    EXPECT_LE(std::abs(reading.range_m - truth), options.noise_bound_m() + 1e-12);
    sum2 += (reading.range_m - truth) * (reading.range_m - truth);
    ++count;
  }
  ASSERT_GT(count, 1000);
  EXPECT_NEAR(std::sqrt(sum2 / count), 0.01, 0.001);
}

TEST(SonarRing, DropoutsSilenceEchoesAndCrosstalkOnlyShortensThem) {
  World world = empty_room();
  world.obstacles = {thing(CylinderShape{0.3, 0.6}, {1.5, 0, 0.3})};
  SonarOptions options = quiet();
  options.dropout_rate = 0.25;
  SonarRing dropping(world, options, {}, 5);
  int dropped = 0, total = 0;
  for (const SonarReading& reading : listen(dropping, {}, 16000)) {
    if (reading.transducer != 3) continue;
    ++total;
    dropped += reading.echo ? 0 : 1;
  }
  EXPECT_NEAR(static_cast<double>(dropped) / total, 0.25, 0.05);

  options.dropout_rate = 0;
  options.crosstalk_rate = 0.3;
  SonarRing disturbed(world, options, {}, 5);
  int shortened = 0;
  for (const SonarReading& reading : listen(disturbed, {}, 16000)) {
    const double truth = std::min(5.0, disturbed.true_range_m({}, reading.transducer, 0));
    EXPECT_LE(reading.range_m, truth);
    shortened += reading.range_m < truth ? 1 : 0;
  }
  EXPECT_NEAR(shortened / 16000.0, 0.3, 0.02);
}

TEST(SonarRing, FaultsDoWhatTheySay) {
  World world = empty_room();
  world.obstacles = {thing(BoxShape{{0.2, 30, 0.6}}, {2.0, 0, 0.3})};
  using Kind = SonarFault::Kind;
  const std::vector<SonarFault> faults{{Kind::dead, 2, 1.0, 0},
                                       {Kind::stuck, 3, 0, 0},
                                       {Kind::reads_long, 4, 0, 0.7},
                                       {Kind::late, 5, 0, 0.5}};
  SonarRing ring(world, SonarOptions{}, faults, 9);
  std::map<std::size_t, std::vector<SonarReading>> heard;
  std::map<std::size_t, double> latest;
  Pose2 pose;
  for (int k = 0; k < 400; ++k) {
    pose.x_m = 0.001 * k;
    ring.fire(pose);
    ring.deliver(ring.next_s(), [&](const SonarReading& reading) {
      heard[reading.transducer].push_back(reading);
      const double age_s = ring.next_s() - reading.fired_s;
      latest[reading.transducer] = std::max(latest[reading.transducer], age_s);
    });
  }
  for (const SonarReading& reading : heard[2]) EXPECT_LT(reading.fired_s, 1.0);
  ASSERT_GT(heard[3].size(), 20u);
  for (const SonarReading& reading : heard[3]) EXPECT_EQ(reading.range_m, heard[3][0].range_m);
  EXPECT_NEAR(heard[4][0].range_m, ring.true_range_m({}, 4, 0) + 0.7, 0.02);
  EXPECT_GE(latest[5], 0.5);
  EXPECT_LT(latest[1], 0.06);
  EXPECT_GT(heard[6].size(), 20u);
}

}  // namespace
}  // namespace ballservo
