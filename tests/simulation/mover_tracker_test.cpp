#include "servo/avoidance/mover_tracker.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "servo/simulation/robot/sonar_ring.hpp"

namespace ballservo {
namespace {

constexpr MovingThingOptions rollers{0.3, 0.2};

World room_with(const Eigen::Vector2d& p, double speed_mps) {
  World world;
  world.room = {-4, 4, -4, 4, 2.5, {}, {}, {}};
  Ball ball;
  ball.name = "thing";
  ball.sonar = true;
  ball.diameter_m = 2 * rollers.radius_m;
  ball.position_m = {p.x(), p.y(), rollers.radius_m};
  if (speed_mps > 0) ball.motion = RollingMotion{{0, speed_mps}};
  world.balls.push_back(ball);
  return world;
}

/// What a robot at rest in the middle knows after so long.
MoverTracker::Movers listen(const World& world, double until_s, std::uint64_t seed) {
  SonarRing ring(world, {}, {}, seed);
  MoverTracker tracker(rollers, {});
  double time_s = 0;
  for (; time_s < until_s; time_s += 0.02) {
    tracker.move(time_s);
    while (ring.next_s() <= time_s) {
      if (const auto firing = ring.fire({})) tracker.look(firing->reading, {});
    }
  }
  return tracker.movers();
}

MovingDisc mean_of(const Mover& mover) {
  MovingDisc mean;
  for (const MovingDisc& disc : mover.discs) {
    mean.p_O += disc.p_O / Mover::guesses;
    mean.v_O += disc.v_O / Mover::guesses;
  }
  return mean;
}

TEST(MoverTracker, HearsTheNearestOfADiscThatLiesInTheBeam) {
  const SonarBeam beam;
  const MoverTracker tracker(rollers, beam);
  int beside = 0;
  for (double y_m = -2; y_m < 2; y_m += 0.037) {
    const Eigen::Vector2d p(1.5, y_m);
    double nearest_m = 1e9;
    for (int k = 0; k < 3600; ++k) {
      const double around = k * M_PI / 1800;
      const Eigen::Vector2d q = p + rollers.radius_m * Eigen::Vector2d(std::cos(around), std::sin(around));
      if (std::abs(std::atan2(q.y(), q.x())) < beam.half_angle_rad) nearest_m = std::min(nearest_m, q.norm());
    }
    beside += nearest_m < 1e9 && std::abs(std::atan2(p.y(), p.x())) > beam.half_angle_rad;
    if (nearest_m < 1e9)
      EXPECT_NEAR(tracker.heard_from_m(p), nearest_m, 0.003) << y_m;
    else
      EXPECT_GT(tracker.heard_from_m(p), 1e9) << y_m;
  }
  EXPECT_GT(beside, 4);
}

TEST(MoverTracker, TellsWhereAThingIsAndHowItMoves) {
  int known = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    RandomEngine engine = random_stream(seed, "mover");
    const double speed_mps = uniform(engine, 0.1, 0.3), from_m = uniform(engine, -1.4, -1.0);
    constexpr double until_s = 6;
    const World world = room_with({uniform(engine, 0.8, 1.2), from_m}, speed_mps);
    const MoverTracker::Movers movers = listen(world, until_s, seed);
    const Eigen::Vector2d truth = world.balls[0].p_WB(until_s).head<2>();
    for (std::size_t k = 0; k < movers.count; ++k) {
      const MovingDisc mean = mean_of(movers.movers[k]);
      if ((mean.p_O - truth).norm() > 0.3) continue;
      ++known;
      EXPECT_LT((mean.p_O - truth).norm(), 0.15) << seed;
      EXPECT_LT((mean.v_O - Eigen::Vector2d(0, speed_mps)).norm(), 0.08) << seed;
    }
  }
  EXPECT_GE(known, 9);
}

TEST(MoverTracker, DoubtsTheVelocityOfWhatItHasJustHeard) {
  const World world = room_with({1.5, 0.3}, 0.2);
  double early_mps = 0, late_mps = 0;
  int early = 0, late = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto doubt = [&](double until_s, double& sum_mps, int& count) {
      const MoverTracker::Movers movers = listen(world, until_s, seed);
      for (std::size_t k = 0; k < movers.count; ++k, ++count) sum_mps += movers.movers[k].speed_sigma_mps;
    };
    doubt(1.5, early_mps, early);
    doubt(6, late_mps, late);
  }
  ASSERT_GT(early, 3);
  ASSERT_GT(late, 7);
  EXPECT_GT(early_mps / early, 2 * late_mps / late);
}

TEST(MoverTracker, NothingMovesWhereAllRests) {
  for (std::uint64_t seed = 0; seed < 10; ++seed)
    EXPECT_EQ(listen(room_with({1.2, 0.2}, 0), 10, seed).count, 0U) << seed;
}

TEST(MoverTracker, TakesAnyReadingAndAnyClock) {
  MoverTracker tracker(rollers, {});
  RandomEngine engine(1);
  const double odd[] = {0, -1, 1e-320, 1e308, NAN, INFINITY, 1.5, 0.5};
  const auto any = [&] { return odd[uniform_index(engine, 8)]; };
  for (int k = 0; k < 20000; ++k) {
    tracker.move(any());
    tracker.look({any(), uniform_index(engine, 20), any(), uniform_index(engine, 2) == 0},
                 {any(), any(), any()});
  }
  const MoverTracker::Movers movers = tracker.movers();
  EXPECT_LE(movers.count, MoverTracker::max_movers);
}

}  // namespace
}  // namespace ballservo
