#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "servo/motion/camera_mount.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "servo/simulation/world/world.hpp"
#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

TEST(Planckian, DaylightIsAlmostWhiteAndTheRestWarmOrCold) {
  // sRGB's white is daylight of 6504 K, a little greener than the black body of that temperature.
  EXPECT_LT((planckian_rgb(6504) - Rgb::Ones()).cwiseAbs().maxCoeff(), 0.06);
  Rgb warmer = planckian_rgb(min_temperature_k);
  for (double k = 1700; k <= max_temperature_k; k += 100) {
    const Rgb rgb = planckian_rgb(k);
    EXPECT_NEAR(0.2126729 * rgb.x() + 0.7151522 * rgb.y() + 0.0721750 * rgb.z(), 1, 0.01) << k;
    EXPECT_GE(rgb.z() / rgb.x(), warmer.z() / warmer.x()) << k;
    EXPECT_LT((rgb - warmer).cwiseAbs().maxCoeff(), 0.15) << k;  // no jumps between the formula's pieces
    warmer = rgb;
  }
}

TEST(LightCourse, RampsAndJumps) {
  const LightCourse course{4000, {{1, 4000, 1}, {3, 4000, 0.5}, {3, 8000, 1}, {5, 6000, 1}}};
  for (const double time_s : {0.0, 1.0}) EXPECT_LT((course.gain(time_s) - Rgb::Ones()).norm(), 1e-12);
  EXPECT_LT((course.gain(2) - 0.75 * Rgb::Ones()).norm(), 1e-12);
  EXPECT_LT((course.gain(3 - 1e-9) - 0.5 * Rgb::Ones()).norm(), 1e-6);
  const auto seen_at = [](double k) -> Rgb { return planckian_rgb(k).cwiseQuotient(planckian_rgb(4000)); };
  EXPECT_LT((course.gain(3) - seen_at(8000)).norm(), 1e-12);
  EXPECT_LT((course.gain(4) - seen_at(7000)).norm(), 1e-12);
  EXPECT_LT((course.gain(99) - seen_at(6000)).norm(), 1e-12);
  EXPECT_EQ(LightCourse{}.gain(7), Rgb::Ones());
}

TEST(World, LooksAlikeWhileNothingMovesOrChanges) {
  const LightCourse later{6500, {{2, 6500, 1}, {3, 6500, 0.5}}};
  World moving, lamp, ambient;
  moving.balls = {test::white_ball({2.0, 0.1, 0.06}, 0.12), test::white_ball({3.0, 0.1, 0.06}, 0.12)};
  moving.balls[1].motion = LinearMotion{{0.1, 0}, 2};
  lamp.lights = {{{1.5, 0.8, 2.4}, {4, 4, 4}, 0.2, later}};
  ambient.changing_ambient = {{{0.2, 0.2, 0.2}, later}};
  for (const World& world : {moving, lamp, ambient}) {
    EXPECT_TRUE(looks_alike(world, 0.5, 1.5));
    EXPECT_FALSE(looks_alike(world, 1.5, 2.5));
  }
}

// A lamp and the light from everywhere, each with its own course, at a moment: as if they always were so.
TEST(LightCourse, ShowsInThePictures) {
  const LightCourse warm{4000, {{0, 4000, 1}, {10, 2500, 0.6}}}, cold{4000, {{0, 4000, 1}, {10, 9000, 0.3}}};
  World changing;
  changing.room.wall.texture.color = {0.6, 0.6, 0.5};
  changing.balls = {test::white_ball({2.0, 0.1, 0.06}, 0.12)};
  changing.balls[0].material = {};
  changing.balls[0].material.texture.color = {0.7, 0.2, 0.1};
  changing.lights = {{{1.5, 0.8, 2.4}, {4, 4, 4}, 0.2, warm}, {{3.0, -1.0, 2.4}, {2, 2, 2}, 0.1}};
  changing.ambient = {0.1, 0.1, 0.1};
  changing.changing_ambient = {{{0.2, 0.2, 0.2}, cold}};
  World still = changing;
  still.lights[0].intensity = 4 * warm.gain(5);
  still.lights[0].course = {};
  still.ambient += 0.2 * cold.gain(5);
  still.changing_ambient.clear();
  const auto picture = [](const World& world) {
    const CameraView view{X_WR({0, 0, 0}) * CameraMount{}.X_RC(), 5};
    return CameraRenderer(test::lens(LensModel::pinhole), world, {}).radiance({view});
  };
  EXPECT_LT(cv::norm(picture(changing), picture(still), cv::NORM_INF), 1e-5);
}

TEST(WaypointMotion, IsAtItsPointsInTimeAndStraightBetween) {
  Ball ball;
  ball.motion = WaypointMotion{{{0, {1, 0, 0.1}}, {2, {1, 0, 0.1}}, {4, {2, 1, 0.5}}}};
  EXPECT_EQ(ball.p_WB(-1), Eigen::Vector3d(1, 0, 0.1));
  EXPECT_EQ(ball.p_WB(1.5), Eigen::Vector3d(1, 0, 0.1));
  EXPECT_LT((ball.p_WB(3) - Eigen::Vector3d(1.5, 0.5, 0.3)).norm(), 1e-12);
  EXPECT_EQ(ball.p_WB(9), Eigen::Vector3d(2, 1, 0.5));
}

}  // namespace
}  // namespace ballservo
