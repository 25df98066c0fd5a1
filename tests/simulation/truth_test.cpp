#include "servo/simulation/rendering/truth.hpp"

#include <gtest/gtest.h>

#include "calibration/base/random.hpp"
#include "servo/simulation/rendering/scene.hpp"
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
  EXPECT_NEAR((truth.p_CB - Eigen::Vector3d(-0.1, -0.1, 2)).norm(), 0, 1e-12);
}

TEST(Truth, HalfAScreenHidesHalf) {
  World world = test::dark_room();
  world.balls = {test::white_ball({2, 0, 250}, 0.2)};
  world.obstacles = {screen(1.0, 0.0)};
  EXPECT_NEAR(truth_of(world).visible_fraction, 0.5, 0.003);
  world.obstacles = {screen(1.0, -1.0)};
  EXPECT_EQ(truth_of(world).visible_fraction, 0.0);
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
  EXPECT_NEAR(truth_of(world, camera).visible_fraction, 0.5, 0.02) << "half but for the curve";
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

/// The share of the outline's pixels, four by four of each, whose rays lie in the picture and meet the ball
/// first.
double counted_fraction(const Camera& camera, const World& world, const CameraView& view) {
  const Scene scene(world, 0);
  const Eigen::Vector3d away = scene.balls()[0].center - view.X_WC.translation();
  const double radius = scene.balls()[0].radius, cosine = std::sqrt(1 - radius * radius / away.squaredNorm());
  const auto outline = project_outline(camera, view.X_WC.inverse() * scene.balls()[0].center, radius, 64);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outline) box.extend(p);
  double all = 0, seen = 0;
  const double step = box.sizes().maxCoeff() / 110;
  for (double v = box.min().y(); v < box.max().y(); v += step) {
    for (double u = box.min().x(); u < box.max().x(); u += step) {
      const auto ray_C = camera.unproject({u, v});
      if (!ray_C) continue;
      const Eigen::Vector3d ray = view.X_WC.linear() * *ray_C;
      if (ray.dot(away) < away.norm() * cosine) continue;
      all += 1;
      const double limit = ray.dot(away);
      bool hidden = scene.hit_solids(view.X_WC.translation(), ray, limit) < limit;
      for (std::size_t k = 1; k < scene.balls().size(); ++k) {
        const Eigen::Vector3d other = scene.balls()[k].center - view.X_WC.translation();
        const double along = other.dot(ray);
        hidden |= along > 0 && along < limit &&
                  other.squaredNorm() - along * along < std::pow(scene.balls()[k].radius, 2);
      }
      const bool inside =
          u >= -0.5 && v >= -0.5 && u <= camera.size().width_px - 0.5 && v <= camera.size().height_px - 0.5;
      seen += inside && !hidden ? 1 : 0;
    }
  }
  return seen / all;
}

// Boxes, columns, plates and balls at random about the way to a ball that may be cut by the picture's border.
TEST(Truth, VisibleFractionsAgreeWithCountedRays) {
  RandomEngine engine = random_stream(0, "visible fraction");
  int partly = 0, cut = 0;
  for (int trial = 0; trial < 120; ++trial) {
    const Camera camera = test::lens(trial % 2 == 0 ? LensModel::brown : LensModel::kannala_brandt);
    World world = test::dark_room();
    const double far_m = uniform(engine, 0.6, 3);
    const Eigen::Vector3d aside(0, uniform(engine, -0.8, 0.8) * far_m,
                                250 + uniform(engine, -0.6, 0.6) * far_m);
    world.balls = {test::white_ball({far_m, aside.y(), aside.z()}, 0.2)};
    for (int k = 0; k < 3; ++k) {
      const double share = uniform(engine, 0.2, 1.2), size = uniform(engine, 0.02, 0.25);
      const Eigen::Vector3d p(share * far_m, share * aside.y() + uniform(engine, -0.25, 0.25),
                              250 + share * (aside.z() - 250) + uniform(engine, -0.25, 0.25));
      if ((p - world.balls[0].position_m).norm() < 0.11 + 2 * size || p.x() < 2 * size) continue;
      Obstacle thing;
      thing.center_m = p;
      thing.yaw_rad = uniform(engine, -3, 3);
      switch (uniform_index(engine, 4)) {
        case 0:
          thing.shape = BoxShape{{size, 2 * size, size}};
          break;
        case 1:
          thing.shape = CylinderShape{size / 2, 2 * size};
          break;
        case 2:
          thing.shape = DiscShape{size};
          break;
        default:
          world.balls.push_back(test::white_ball(p, 2 * size));
          continue;
      }
      world.obstacles.push_back(thing);
    }
    const CameraView view{test::level_view(), 0};
    const BallTruth truth = ball_truth(camera, world, view, 0);
    if (!truth.outline) continue;
    const double counted = counted_fraction(camera, world, view);
    EXPECT_NEAR(truth.visible_fraction, counted, 0.006) << "trial " << trial;
    partly += counted > 0.05 && counted < 0.95 ? 1 : 0;
    cut += !is_inside_picture(project_outline(camera, truth.p_CB, 0.1, 64), camera.size()) && counted > 0 ? 1
                                                                                                          : 0;
  }
  EXPECT_GT(partly, 20);
  EXPECT_GT(cut, 10);
}

}  // namespace
}  // namespace ballservo
