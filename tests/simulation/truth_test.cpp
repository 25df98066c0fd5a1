#include "servo/simulation/truth.hpp"

#include <gtest/gtest.h>

#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

BallTruth truth_of(const World& world, const Camera& camera = test::lens(LensModel::pinhole)) {
  return ball_truth(camera, world, {test::level_view(), 0}).front();
}

Obstacle screen(double left_m, double right_m) {
  Obstacle box;
  box.shape = BoxShape{{0.01, left_m - right_m, 2}};
  box.center_m = {1.0, (left_m + right_m) / 2, 250};
  return box;
}

TEST(Truth, AFreeBallIsSeenWhole) {
  World world = test::dark_room();
  world.balls = {test::white_ball({2, 0.1, 250.1}, 0.2)};
  const BallTruth truth = truth_of(world);
  EXPECT_EQ(truth.visible_fraction, 1.0);
  EXPECT_TRUE(truth.center_in_view);
  EXPECT_FALSE(truth.center_hidden);
  EXPECT_NEAR((truth.p_CB - Eigen::Vector3d(-0.1, -0.1, 2)).norm(), 0, 1e-12);
}

TEST(Truth, HalfAScreenHidesHalf) {
  World world = test::dark_room();
  world.balls = {test::white_ball({2, 0, 250}, 0.2)};
  world.obstacles = {screen(1.0, 0.0)};
  EXPECT_NEAR(truth_of(world).visible_fraction, 0.5, 0.012);
  world.obstacles = {screen(1.0, -1.0)};
  EXPECT_EQ(truth_of(world).visible_fraction, 0.0);
  EXPECT_TRUE(truth_of(world).center_hidden);
  world.obstacles[0].center_m.x() = 3.0;  // behind the ball
  EXPECT_EQ(truth_of(world).visible_fraction, 1.0);
}

TEST(Truth, ABallInFrontHidesOneBehind) {
  World world = test::dark_room();
  world.balls = {test::white_ball({4, 0, 250}, 0.2), test::white_ball({2, 0, 250}, 0.2)};
  const auto truths = ball_truth(test::lens(LensModel::pinhole), world, {test::level_view(), 0});
  EXPECT_EQ(truths[0].visible_fraction, 0.0);
  EXPECT_EQ(truths[1].visible_fraction, 1.0);
}

TEST(Truth, TheBorderCutsTheOutline) {
  World world = test::dark_room();
  const Camera camera = test::lens(LensModel::pinhole);
  // The ray through the right border's middle, 2 m away: the outline's ellipse is nearly centred on it.
  const Eigen::Vector3d ray = *camera.unproject({639.5, camera.parameters().cy_px});
  world.balls = {test::white_ball(test::level_view() * (2 * ray / ray.z()), 0.1)};
  EXPECT_NEAR(truth_of(world, camera).visible_fraction, 0.5, 0.02);
}

TEST(Truth, OutsideOrBehindNothingIsSeen) {
  World world = test::dark_room();
  world.balls = {test::white_ball({2, 5, 250}, 0.2)};
  EXPECT_EQ(truth_of(world).visible_fraction, 0.0);
  EXPECT_FALSE(truth_of(world).center_in_view);
  world.balls = {test::white_ball({-2, 0, 250}, 0.2)};
  EXPECT_EQ(truth_of(world).visible_fraction, 0.0);
  EXPECT_FALSE(truth_of(world).outline);
}

}  // namespace
}  // namespace ballservo
