// What a seed draws of a world: where a ball is carried, where balls lie about.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/scenario/scenario.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using ::testing::HasSubstr;

Scenario carried(std::uint64_t seed, const std::vector<std::string>& sets = {}) {
  return load_scenario(test::project_data_dir() / "scenarios" / "carried_ball.yaml", sets, seed);
}

std::vector<WaypointMotion::Point> points(const Scenario& scenario) {
  return std::get<WaypointMotion>(scenario.target_ball().motion).points;
}

constexpr double lift_m = 0.20, speed_mps = 0.25;  // as carried_ball.yaml has them

TEST(CarriedBall, IsLiftedCarriedAndPutDownWhileThereIsTime) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scenario scenario = carried(seed);
    const Ball& ball = scenario.target_ball();
    double highest_m = 0;
    for (double time_s = 0; time_s < 39.9; time_s += 0.1) {
      const Eigen::Vector3d now = ball.p_WB(time_s), next = ball.p_WB(time_s + 0.1), step = next - now;
      ASSERT_LE(step.norm(), 0.1 * speed_mps + 1e-12);
      if (step.head<2>().norm() > 1e-9 && step.z() == 0) {
        ASSERT_NEAR(now.z(), 0.06 + lift_m, 1e-12);
      }
      highest_m = std::max(highest_m, now.z());
      if (time_s > 32) {
        ASSERT_EQ(now, next);
      }
    }
    EXPECT_NEAR(highest_m, 0.06 + lift_m, 1e-12);
    EXPECT_EQ(ball.heights_m(), std::make_pair(0.06, 0.06 + lift_m));
    const Eigen::Vector3d end = ball.p_WB(40);
    EXPECT_EQ(end.z(), 0.06);
    EXPECT_TRUE(2 <= end.x() && end.x() <= 5 && std::abs(end.y()) <= 1.5) << end.transpose();
    EXPECT_NE(end, carried(seed + 1).target_ball().p_WB(40));
    EXPECT_EQ(end, carried(seed).target_ball().p_WB(40));
  }
}

TEST(CarriedBall, GoesAroundWhatStandsThere) {
  const std::string column =
      "obstacles=[{type: cylinder, radius_m: 0.4, height_m: 0.5, position: {x_m: 3.5, y_m: 0.3}}]";
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scenario scenario = carried(seed, {column});
    EXPECT_GT(points(scenario).size(), 4u);
    for (double time_s = 0; time_s < 40; time_s += 0.1) {
      const Eigen::Vector2d p = scenario.target_ball().p_WB(time_s).head<2>();
      ASSERT_GT((p - Eigen::Vector2d(3.5, 0.3)).norm(), 0.4 + 0.06);
    }
  }
}

TEST(CarriedBall, StaysWhereNoWayIsClearAndEndsWhereWaysTakeNoTime) {
  EXPECT_EQ(
      points(
          carried(1, {"balls.0.motion.x_m=[2.5, 2.5]", "balls.0.motion.y_m=[0, 0]", "balls.0.position.y_m=0",
                      "obstacles=[{type: cylinder, radius_m: 0.4, height_m: 0.5, position: {x_m: 2.5, "
                      "y_m: 0.48}}]"}))
          .size(),
      1u);
  EXPECT_LT(points(carried(1, {"balls.0.motion.x_m=[2.5, 2.5]", "balls.0.motion.y_m=[0, 0]",
                               "balls.0.position.y_m=0", "balls.0.motion.height_m=0",
                               "balls.0.motion.rest_s=[0, 0]"}))
                .size(),
            5000u);
}

TEST(CarriedBall, FaultsAreNamed) {
  const auto fault_of = [](const std::string& set) -> std::string {
    try {
      carried(0, {set});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(fault_of("balls.0.motion.speed_mps=0"), HasSubstr("balls[0].motion.speed_mps"));
  EXPECT_THAT(fault_of("balls.0.motion.rest_s=[3, 1]"), HasSubstr("falling order"));
  EXPECT_THAT(fault_of("balls.0.motion.height_m=-0.1"), HasSubstr("balls[0].motion.height_m"));
  EXPECT_THAT(fault_of("balls.0.motion.x_m=[8, 9]"), HasSubstr("outside the room"));
  EXPECT_THAT(fault_of("obstacles.0.shape=star"), HasSubstr("one of box, cylinder, disc, ball"));
}

TEST(StrewnBall, LiesOnTheFloorClearOfTheTargetsWay) {
  int strewn = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Scenario scenario = carried(seed);
    const std::vector<Ball>& balls = scenario.world.balls;
    ASSERT_GE(balls.size(), 2u) << "at least one orange ball";
    EXPECT_EQ(balls[1].name.rfind("orange_ball_1_", 0), 0u);
    EXPECT_EQ(balls[1].class_name, "orange");
    for (std::size_t k = 1; k < balls.size(); ++k, ++strewn) {
      EXPECT_NEAR(balls[k].position_m.z(), balls[k].radius_m(), 1e-12);
      for (double time_s = 0; time_s < 40; time_s += 0.1) {
        const double gap_m = (balls[k].position_m - scenario.target_ball().p_WB(time_s)).head<2>().norm() -
                             balls[k].radius_m() - 0.06;
        ASSERT_GE(gap_m, 0.3 - 1e-9) << balls[k].name;
      }
      for (std::size_t j = 1; j < k; ++j) {
        EXPECT_GE((balls[k].position_m - balls[j].position_m).head<2>().norm(),
                  balls[k].radius_m() + balls[j].radius_m() + 0.3 - 1e-9);
      }
    }
  }
  EXPECT_GT(strewn, 40);
}

}  // namespace
}  // namespace ballservo
