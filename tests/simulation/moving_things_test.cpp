#include "servo/avoidance/moving_things.hpp"

#include <gtest/gtest.h>

#include "tests/simulation/shielded_robot.hpp"

namespace ballservo {
namespace {

using test::RecklessDriver;
using test::ShieldedRobot;

constexpr MovingThingOptions people{0.3, 0.2};

/// How far from the footprint, at that pose, none can be; at most 2 m.
double clearance_m(const MovingThings& things, const Pose2& pose) {
  double clear_m = 0;
  for (double step_m = 1; step_m > 0.02; step_m *= 0.5) {
    if (!things.may_touch(pioneer_3dx_footprint, pose, clear_m + step_m, 0)) clear_m += step_m;
  }
  return clear_m;
}

TEST(MovingThings, ComeNearerUnlessSonarsShowThatTheyDoNot) {
  MovingThings things(people, OccupancyGridOptions{});
  const auto clear_m = [&things](double y_m) { return clearance_m(things, {0, y_m, 0}); };
  things.move(0, {});
  const double at_first_m = clear_m(0);
  EXPECT_NEAR(at_first_m, 0.70 - pioneer_3dx_footprint.reach_m(), 0.15) << "the disc of the start";
  things.move(0.5, {});
  EXPECT_NEAR(clear_m(0), at_first_m - 0.15, 0.04);
  things.move(4, {});
  EXPECT_EQ(clear_m(0), 0) << "one may be close by now";
  for (int twice = 0; twice < 2; ++twice) {
    for (std::size_t k = 0; k < sonar_count; ++k) things.look({4, k, k == 0 ? 0.8 : 5.0, k == 0}, {});
  }
  EXPECT_GT(clear_m(0), 0.4) << "gaps between cones are too narrow for it";
  EXPECT_LT(clear_m(0.7), 0.1) << "this is where something was heard";
  things.move(5, {});
  EXPECT_LT(clear_m(0), 0.3);
}

TEST(MovingThings, AreEverywhereAfterAnyLeapOfClockOrOdometry) {
  for (const Pose2& pose : {Pose2{}, Pose2{9e5, -9e5, 9e5}}) {
    MovingThings things(people, OccupancyGridOptions{});
    things.move(0, {});
    things.move(1e12, pose);
    EXPECT_EQ(clearance_m(things, pose), 0);
    EXPECT_TRUE(things.may_touch(pioneer_3dx_footprint, {NAN, 0, 0}, 0, 0));
  }
}

TEST(MovingThings, AreReckonedWithUntilTheRobotRests) {
  OccupancyGrid grid(OccupancyGridOptions{});
  MovingThings things(people, OccupancyGridOptions{});
  grid.move(0, {});
  ShieldOptions options;
  options.delay_s = 0.05;
  int passed = 0;
  for (double time_s = 0; time_s < 1; time_s += 0.01) {
    things.move(time_s, {});
    for (const double v_mps : {0.01, 0.02, 0.04, 0.08, 0.16}) {
      const Twist2 command{v_mps, 0};
      if (can_brake_after(command, {{}, command}, grid, options, &things) == Brake::blocked) continue;
      ++passed;
      const double brake_s = v_mps / options.limits.a_max_mps2;
      const Pose2 end{v_mps * (options.period_s + 0.5 * brake_s), 0, 0};
      EXPECT_FALSE(things.may_touch(options.footprint, end, drive_model_m,
                                    options.delay_s + options.period_s + brake_s))
          << time_s << " " << v_mps;
    }
  }
  EXPECT_GT(passed, 50);
}

/// Runs after the robot, or away from it where it has touched it, at its greatest speed.
void chase(Ball& ball, const Pose2& robot, bool away, double speed_mps) {
  const Eigen::Vector2d to = Eigen::Vector2d(robot.x_m, robot.y_m) - ball.position_m.head<2>();
  ball.position_m.head<2>() += to.normalized() * (away ? -1 : 1) * speed_mps * ShieldedRobot::period_s;
}

struct Chase {
  int hits_while_moving = 0, hits_at_rest = 0;
  double way_m = 0;
};

/// Discs go for a robot that a reckless driver drives; each turns back for a while after a hit.
Chase run_while_chased(std::uint64_t seed, const MovingThingOptions& reckoned) {
  RandomEngine engine = random_stream(seed, "moving");
  World world;
  world.room = {-4, 4, -4, 4, 2.5, {}, {}, {}};
  for (int k = 0; k < 3; ++k) {
    Ball ball;
    ball.name = "thing";
    ball.sonar = true;
    ball.diameter_m = 2 * uniform(engine, people.radius_m, 0.4);
    const double angle = uniform(engine, 0, 6.28);
    ball.position_m = {3 * std::cos(angle), 3 * std::sin(angle), 0.5 * ball.diameter_m};
    world.balls.push_back(ball);
  }
  ShieldedRobot robot(world, 0.05, seed, reckoned);
  RecklessDriver driver(engine);
  Chase chased;
  Twist2 last;
  std::array<int, 3> away{};
  bool touched = false;
  for (int k = 0; k < 3000; ++k) {
    const Pose2 before = robot.pose();
    last = robot.step(driver.next(last)).command;
    chased.way_m += std::hypot(robot.pose().x_m - before.x_m, robot.pose().y_m - before.y_m);
    const bool touches = find_contacts(world, pioneer_3dx_footprint, robot.pose(), 0).ball_contact();
    const bool moves = robot.twist().v_mps != 0 || robot.twist().w_radps != 0;
    if (touches && !touched) ++(moves ? chased.hits_while_moving : chased.hits_at_rest);
    touched = touches;
    for (std::size_t each = 0; each < away.size(); ++each) {
      Ball& ball = world.balls[each];
      const double gap_m =
          pioneer_3dx_footprint.distance_m(in_robot_frame(robot.pose(), ball.position_m.head<2>())) -
          ball.radius_m();
      if (gap_m <= 0 && away[each] == 0) away[each] = 200 + static_cast<int>(uniform_index(engine, 300));
      chase(ball, robot.pose(), away[each] > 0, people.speed_mps);
      away[each] = std::max(0, away[each] - 1);
    }
  }
  return chased;
}

TEST(MovingThings, TouchARecklessRobotOnlyAtRestHoweverTheyChaseIt) {
  Chase all, unreckoned;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Chase chased = run_while_chased(seed, people);
    EXPECT_EQ(chased.hits_while_moving, 0) << seed;
    all.hits_at_rest += chased.hits_at_rest;
    all.way_m += chased.way_m;
    unreckoned.hits_while_moving += run_while_chased(seed, {}).hits_while_moving;
  }
  EXPECT_GT(all.hits_at_rest, 20) << "things that touch nothing prove nothing";
  EXPECT_GT(all.way_m, 20) << "a robot that stands proves nothing";
  EXPECT_GT(unreckoned.hits_while_moving, 10);
}

}  // namespace
}  // namespace ballservo
