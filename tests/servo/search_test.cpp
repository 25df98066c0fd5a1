#include "servo/control/search.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ballservo {
namespace {

/// A robot that turns as it is told from step to step, unless something holds it.
struct Turning {
  Search search;
  Pose2 pose;
  double time_s = 0;
  double turned_rad = 0, leftmost_rad = 0, rightmost_rad = 0;

  explicit Turning(const Pose2& start = {}) : pose(start) { search.start(0, start); }

  /// One turn, at most so long; whether it came to its end. `held`: the shield lets the robot not turn.
  bool turn(double at_most_s, bool held = false) {
    Twist2 twist;
    for (const double until_s = time_s + at_most_s; time_s < until_s; time_s += 0.02) {
      search.note_heading(pose.yaw_rad, true);
      if (search.turn(time_s, twist)) return true;
      twist = held ? Twist2{} : search.turn_command(time_s);
      EXPECT_EQ(twist.v_mps, 0);
      pose.yaw_rad += 0.02 * twist.w_radps;
      turned_rad += 0.02 * std::abs(twist.w_radps);
      leftmost_rad = std::max(leftmost_rad, pose.yaw_rad);
      rightmost_rad = std::min(rightmost_rad, pose.yaw_rad);
    }
    return false;
  }
};

TEST(Search, LooksBeforeItTurnsThenAsideThenAllAround) {
  Turning robot;
  EXPECT_FALSE(robot.turn(Search::look_s - 0.05));
  EXPECT_EQ(robot.turned_rad, 0);
  EXPECT_TRUE(robot.turn(60));
  EXPECT_GT(robot.leftmost_rad, 0.55);
  EXPECT_LT(robot.leftmost_rad, 0.7) << "a little to one side";
  EXPECT_GT(robot.leftmost_rad - robot.rightmost_rad, 2 * M_PI) << "then all around, the other way";
}

TEST(Search, LooksAsideOnlyOnce) {
  Turning robot;
  ASSERT_TRUE(robot.turn(60));
  const double before_rad = robot.pose.yaw_rad;
  robot.turned_rad = 0;
  robot.search.begin_turn(robot.time_s);
  ASSERT_TRUE(robot.turn(60));
  EXPECT_NEAR(std::abs(robot.pose.yaw_rad - before_rad), robot.turned_rad, 1e-9) << "one way only";
}

TEST(Search, TurnsTowardsTheSideOnWhichTheBallWasSeen) {
  for (const double bearing_rad : {-0.4, 0.4}) {
    Turning robot;
    robot.search.note_ball(bearing_rad);
    robot.turn(1.0);
    EXPECT_GT(robot.pose.yaw_rad * bearing_rad, 0);
  }
}

TEST(Search, WhereNoTurnIsPossibleBothWaysAreTriedAndThenItEnds) {
  Turning robot;
  bool left = false, right = false, ended = false;
  for (; robot.time_s < 10 && !ended; robot.time_s += 0.02) {
    ended = robot.search.turn(robot.time_s, {});
    const double w_radps = robot.search.turn_command(robot.time_s).w_radps;
    left |= w_radps > 0;
    right |= w_radps < 0;
  }
  EXPECT_TRUE(ended && left && right);
  EXPECT_LT(robot.time_s, 2.5);
  // What could not be turned before may be turned later.
  robot.search.begin_turn(robot.time_s);
  EXPECT_TRUE(robot.turn(60));
  EXPECT_GT(robot.turned_rad, 2 * M_PI);
}

TEST(Search, ATurnThatWasBrokenOffGoesOnWithoutALook) {
  Turning robot;
  robot.turn(3.0);
  robot.search.resume_turn(robot.time_s);
  EXPECT_NE(robot.search.turn_command(robot.time_s).w_radps, 0);
  robot.search.begin_turn(robot.time_s);
  EXPECT_EQ(robot.search.turn_command(robot.time_s).w_radps, 0);
}

TEST(Search, SetsOutSoManyTimesAndAnewWhenTheBallWasFound) {
  Search search;
  search.start(0, {1, 2, 0.5});
  EXPECT_FALSE(search.has_set_out());
  for (int k = 0; k < Search::most_excursions; ++k) {
    ASSERT_TRUE(search.may_set_out());
    search.set_out(0, {1, 2, 0.5}, {3, 2});
  }
  EXPECT_TRUE(search.has_set_out());
  EXPECT_FALSE(search.may_set_out());
  search.forget_excursions();
  EXPECT_TRUE(search.may_set_out());
}

TEST(Search, AnExcursionWithoutAWayLeadsBackToTheStart) {
  Search search;
  search.start(0, {1, 2, 0});
  search.set_out(0, {4, 2, 0}, {4.1, 2});
  EXPECT_EQ(search.destination(), Eigen::Vector2d(1, 2));
  search.set_out(0, {4, 2, 0}, {5, 2});
  EXPECT_EQ(search.destination(), Eigen::Vector2d(5, 2));
}

TEST(Search, AnExcursionEndsWhereTheBrakeTakesItOrWhenItsTimeIsUp) {
  Search search;
  search.start(0, {});
  search.set_out(2.0, {}, {1.5, 0});
  EXPECT_FALSE(search.arrives({1.2, 0, 0}, {0, 0}, 0.3));
  EXPECT_TRUE(search.arrives({1.2, 0, 0}, {0.4, 0}, 0.3)) << "0.27 m of brake";
  EXPECT_TRUE(search.arrives({1.4, 0, 0}, {0, 0}, 0.3));
  EXPECT_FALSE(search.out_of_time(16.9));
  EXPECT_TRUE(search.out_of_time(17.1));
  search.set_out(20.0, {}, {1.5, 0});
  EXPECT_FALSE(search.out_of_time(20.1));
  search.end_excursion();
  EXPECT_TRUE(search.out_of_time(20.1)) << "there is no way";
}

TEST(Search, TurnsToTheSideThatShowsTheRestSoonerAndTurnsBackOnceForMuch) {
  for (const double sooner_left : {0.9, 1.1}) {
    const double side = sooner_left > 1.0 ? 1.0 : -1.0;
    Turning robot;
    const auto turns_to_it = [&] { return robot.search.turn_command(robot.time_s).w_radps * side > 0; };
    robot.search.begin_turn(0);
    robot.search.prefer(sooner_left);
    robot.turn(2.0);
    EXPECT_TRUE(turns_to_it());
    EXPECT_GT(robot.pose.yaw_rad * side, 1.0) << "it is no look aside";
    robot.search.prefer(side > 0 ? 0.8 : 1.25);
    EXPECT_TRUE(turns_to_it()) << "not for little";
    robot.search.prefer(side > 0 ? 0.6 : 1.7);
    EXPECT_FALSE(turns_to_it());
    robot.turn(1.0);
    robot.search.prefer(side > 0 ? 5.0 : 0.2);
    EXPECT_FALSE(turns_to_it()) << "once";
    EXPECT_FALSE(robot.turn(8.0)) << "all around from here";
    robot.search.begin_turn(robot.time_s);
    robot.search.prefer(sooner_left);
    robot.turn(1.0);
    EXPECT_TRUE(turns_to_it()) << "another turn";
  }
}

TEST(Search, KeepsItsSideWhereBothAreAsSoon) {
  Search search;
  search.start(0, {});
  const double before_radps = search.turn_command(2.0).w_radps;
  search.prefer(1.0);
  search.prefer(1.0);
  search.prefer(1.0);
  EXPECT_EQ(search.turn_command(2.0).w_radps, before_radps);
}

TEST(Search, AHeldTurnIsNotPreferred) {
  Turning robot;
  robot.search.begin_turn(0);
  robot.search.prefer(2.0);
  robot.turn(1.5, true);  // held: the other way round is tried
  const double sign = robot.search.turn_command(robot.time_s).w_radps;
  EXPECT_LT(sign, 0);
  robot.search.prefer(9.0);
  EXPECT_EQ(robot.search.turn_command(robot.time_s).w_radps, sign);
}

TEST(Search, MissesABallOnlyWhereItShouldBeSeen) {
  Search search;
  search.expect_ball(1.0);
  EXPECT_FALSE(search.misses_ball(5.0, false));
  EXPECT_FALSE(search.misses_ball(5.3, true));
  EXPECT_TRUE(search.misses_ball(5.5, true));
}

}  // namespace
}  // namespace ballservo
