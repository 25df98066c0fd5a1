#include "servo/avoidance/braking_shield.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "tests/simulation/shielded_robot.hpp"

namespace ballservo {
namespace {

using test::random_world;
using test::RecklessDriver;
using test::ShieldedRobot;

struct Tally {
  long steps = 0, passed = 0, moved = 0, collisions = 0, moving_contacts = 0;
  double way_m = 0;
};

/// A run of a reckless driver; false at the first broken promise.
bool keeps_its_promise(double actuation_delay_s, std::uint64_t seed, int steps, Tally& tally) {
  RandomEngine engine = random_stream(seed, "shield");
  const World world = random_world(engine, OccupancyGridOptions{}.start_clear_m);
  ShieldedRobot robot(world, actuation_delay_s, seed);
  RecklessDriver driver(engine);
  Twist2 last;
  for (int k = 0; k < steps; ++k) {
    const Twist2 asked = driver.next(last);
    const Pose2 before = robot.pose();
    const ShieldVerdict verdict = robot.step(asked);
    last = verdict.command;
    ++tally.steps;
    tally.way_m += std::hypot(robot.pose().x_m - before.x_m, robot.pose().y_m - before.y_m);
    if (verdict.passed && asked.v_mps != 0) ++tally.passed;
    const bool raised = std::abs(last.v_mps) > std::abs(asked.v_mps) ||
                        std::abs(last.w_radps) > std::abs(asked.w_radps) || last.v_mps * asked.v_mps < 0 ||
                        last.w_radps * asked.w_radps < 0;
    const bool rests =
        last.v_mps == 0 && last.w_radps == 0 && robot.twist().v_mps == 0 && robot.twist().w_radps == 0;
    if (raised || (!rests && !robot.brakes_clear())) {
      ++tally.collisions;
      return false;
    }
  }
  return true;
}

// 100 runs of 1000 steps.
TEST(BrakingShield, EveryCommandThatPassesCanBrakeClearAndNoSpeedIsRaised) {
  Tally tally;
  EXPECT_TRUE(rc::check("brakes clear", [&tally](std::uint64_t seed) {
    const double actuation_delay_s = 0.01 * static_cast<double>(seed % 12);
    RC_ASSERT(keeps_its_promise(actuation_delay_s, seed, 1000, tally));
  }));
  EXPECT_GE(tally.steps, 100000);
  EXPECT_GT(tally.passed, tally.steps / 10) << "a shield that lets nothing pass proves nothing";
  EXPECT_GT(tally.way_m, 100) << "a robot that stands proves nothing";
}

TEST(BrakingShield, WithoutItTheSameDriverCollides) {
  int collided = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    RandomEngine engine = random_stream(seed, "shield");
    const World world = random_world(engine, 0.7);
    UnicycleRobot robot({}, ShieldedRobot::limits, 0.05);
    RecklessDriver driver(engine);
    Twist2 last;
    for (int k = 0; k < 1000; ++k) {
      robot.command(last = driver.next(last));
      robot.advance_to(0.02 * (k + 1));
      if (!find_contacts(world, pioneer_3dx_footprint, robot.pose(), 0).collision()) continue;
      ++collided;
      break;
    }
  }
  EXPECT_GE(collided, 8);
}

TEST(BrakingShield, StandsWhereNothingWasEverSeen) {
  OccupancyGridOptions options;
  options.start_clear_m = 0;
  OccupancyGrid grid(options);
  grid.move(0, {});
  const ShieldOptions shield_options;
  EXPECT_EQ(shield({0.1, 0.2}, {}, grid, shield_options).command.v_mps, 0);
  EXPECT_EQ(shield({0, 0.2}, {}, grid, shield_options).command.w_radps, 0);
  EXPECT_TRUE(shield({}, {}, grid, shield_options).passed);
}

/// What is free is the body's own place, with hardly any room at its rear corners, and what lies ahead.
OccupancyGrid seen_ahead_only() {
  OccupancyGridOptions options;
  options.start_clear_m = 0.41;
  OccupancyGrid grid(options);
  grid.move(0, {});
  for (int turn = -12; turn <= 12; ++turn) {
    for (int twice = 0; twice < 2; ++twice) grid.look({0, 3, 5.0, false}, {-0.1, 0, 0.1 * turn - 0.17});
  }
  return grid;
}

TEST(BrakingShield, CreepsSlowlyAndOnlyAway) {
  const OccupancyGrid grid = seen_ahead_only();
  const auto brake = [&grid](const Twist2& twist, bool creep) {
    ShieldOptions options;
    options.creep = creep;
    return can_brake_after(twist, {{}, twist}, grid, options);
  };
  EXPECT_EQ(brake({0.08, 0}, true), Brake::creeping) << "ahead is free, behind nothing comes nearer";
  EXPECT_EQ(brake({0.08, 0}, false), Brake::blocked);
  EXPECT_EQ(brake({0.25, 0}, true), Brake::blocked) << "too fast";
  EXPECT_EQ(brake({-0.08, 0}, true), Brake::blocked) << "behind is not seen, and comes nearer";
  EXPECT_EQ(brake({0.0, 0.2}, true), Brake::blocked) << "so it does where a corner swings out";
}

TEST(BrakingShield, CreepsStraightOnWhereATurnWouldComeNearer) {
  OccupancyGrid grid(OccupancyGridOptions{});
  grid.move(0, {});
  for (const std::size_t side : {0u, 7u}) {  // echoes close beside the front's flanks
    for (int twice = 0; twice < 2; ++twice) grid.look({0, side, 0.14, true}, {});
  }
  const RobotMotion motion{{}, {0.08, 0}};
  EXPECT_EQ(can_brake_after({0.08, 0}, motion, grid, {}), Brake::creeping);
  for (const double turn_radps : {-0.3, -0.01, 0.01, 0.3}) {
    const ShieldVerdict verdict = shield({0.08, turn_radps}, motion, grid, {});
    EXPECT_FALSE(verdict.passed);
    EXPECT_EQ(verdict.command.v_mps, 0.08);
    EXPECT_EQ(verdict.command.w_radps, 0);
    EXPECT_EQ(verdict.reason, creeping_reason);
  }
}

TEST(BrakingShield, DoesNotCreepWhereItsOwnPlaceWasNeverSeen) {
  OccupancyGrid grid(OccupancyGridOptions{});
  grid.move(0, {});
  const Twist2 slow{0.05, 0};
  const auto brake_at = [&](double x_m) { return can_brake_after(slow, {{x_m, 0, 0}, slow}, grid, {}); };
  EXPECT_EQ(brake_at(-0.30), Brake::creeping) << "the body lies in the disc of the start, its margins do not";
  EXPECT_EQ(brake_at(-0.45), Brake::blocked) << "its rear does not";
}

TEST(BrakingShield, IsFiniteAndNeverFasterForAnyInput) {
  OccupancyGrid grid(OccupancyGridOptions{});
  grid.move(0, {});
  const double odd[] = {0.0,
                        0.3,
                        -0.3,
                        1e308,
                        -1e308,
                        std::numeric_limits<double>::denorm_min(),
                        std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(),
                        std::numeric_limits<double>::quiet_NaN()};
  for (const double v : odd) {
    for (const double w : odd) {
      for (const double x : odd) {
        for (const double yaw : odd) {
          for (const double speed : odd) {
            const ShieldVerdict verdict = shield({v, w}, {{x, 0, yaw}, {speed, w}}, grid, {});
            ASSERT_TRUE(std::isfinite(verdict.command.v_mps) && std::isfinite(verdict.command.w_radps));
            if (!std::isfinite(v) || !std::isfinite(w)) continue;
            ASSERT_LE(std::abs(verdict.command.v_mps), std::abs(v));
            ASSERT_LE(std::abs(verdict.command.w_radps), std::abs(w));
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace ballservo
