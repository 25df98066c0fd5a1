#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>

#include "calibration/base/fault.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "tests/simulation/dark_room.hpp"

namespace ballservo {
namespace {

World furnished_room() {
  World world;
  world.room.floor.texture = {Pattern::wood, {0.5, 0.36, 0.21}, {0.3, 0.18, 0.09}, 0.12};
  world.room.wall.texture = {Pattern::noise, {0.66, 0.65, 0.6}, {0.58, 0.57, 0.53}, 0.6};
  Ball ball = test::white_ball({2.0, 0.1, 0.06}, 0.12);
  ball.material = {};
  ball.material.texture.color = {0.7, 0.04, 0.03};
  ball.material.specular = 0.3;
  world.balls = {ball};
  Obstacle box;
  box.name = "box";
  box.shape = BoxShape{{0.3, 0.4, 0.3}};
  box.center_m = {2.5, 0.7, 0.15};
  box.yaw_rad = 0.4;
  box.material.texture.pattern = Pattern::checks;
  Obstacle cylinder = box;
  cylinder.name = "cylinder";
  cylinder.shape = CylinderShape{0.1, 0.5};
  cylinder.center_m = {3.0, -0.6, 0.25};
  world.obstacles = {box, cylinder};
  world.lights = {{{1.5, 0.8, 2.5}, {4, 4, 4}, 0.2}};
  return world;
}

CameraView standing(double x_m = 0) { return {X_WR({x_m, 0, 0}) * CameraMount{}.X_RC(), 0}; }

bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && a.isContinuous() && b.isContinuous() &&
         std::memcmp(a.data, b.data, a.total() * a.elemSize()) == 0;
}

TEST(Renderer, SameBytesAtAnyNumberOfThreads) {
  SensorOptions sensor;
  sensor.blur_px = 0.6;
  sensor.read_noise = 1.5;
  sensor.shot_noise = 0.5;
  const CameraRenderer renderer(test::lens(LensModel::brown), furnished_room(), sensor);
  std::vector<cv::Mat> pictures;
  for (const std::size_t threads : {1u, 2u, 4u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    pictures.push_back(renderer.render({standing()}, 7, 3));
  }
  EXPECT_TRUE(same_bytes(pictures[0], pictures[1]));
  EXPECT_TRUE(same_bytes(pictures[0], pictures[2]));
  EXPECT_FALSE(same_bytes(pictures[0], renderer.render({standing()}, 7, 4)));
  EXPECT_FALSE(same_bytes(pictures[0], renderer.render({standing()}, 8, 3)));
}

/// Rows whose last rays are fewer than are followed at once, and corners without any.
TEST(Renderer, WidthsAndDarkCornersChangeNoOtherPixel) {
  CameraParameters parameters = test::lens(LensModel::kannala_brandt).parameters();
  parameters.size = {320, 200};
  parameters.fx_px = parameters.fy_px = 60;
  parameters.coefficients = {-0.1, 0, 0, 0};  // no ray beyond 73 px
  parameters.cx_px = 140;
  parameters.cy_px = 95;
  const cv::Mat whole = CameraRenderer(Camera(parameters), furnished_room(), {}).radiance({standing()});
  EXPECT_EQ(whole.at<cv::Vec3f>(0, 0), cv::Vec3f(0, 0, 0));
  for (const int width : {313, 157, 1}) {
    parameters.size.width_px = width;
    const cv::Mat cut = CameraRenderer(Camera(parameters), furnished_room(), {}).radiance({standing()});
    const cv::Rect inside(0, 0, std::max(width - 1, 1), 200);  // at the border fewer neighbours tell an edge
    EXPECT_LT(cv::norm(cut(inside), whole(inside), cv::NORM_INF), 1e-6) << width;
  }
}

TEST(Renderer, ANearerSolidHidesTheBall) {
  World world = test::dark_room();
  world.balls = {test::white_ball({3, 0, 250}, 0.2)};
  const CameraRenderer open(test::lens(LensModel::pinhole), world, {});
  Obstacle box;
  box.shape = BoxShape{{0.1, 1, 1}};
  box.center_m = {1.5, 0, 250};
  box.material = test::luminous(Rgb::Zero());
  world.obstacles = {box};
  const CameraRenderer hidden(test::lens(LensModel::pinhole), world, {});
  world.obstacles[0].center_m.x() = 4.5;
  const CameraRenderer behind(test::lens(LensModel::pinhole), world, {});
  const auto light = [](const CameraRenderer& renderer) {
    return cv::sum(renderer.radiance({{test::level_view(), 0}}))[0];
  };
  EXPECT_GT(light(open), 100);
  EXPECT_EQ(light(hidden), 0);
  EXPECT_EQ(light(behind), light(open));
}

TEST(Renderer, ShowsEveryThingInARoomWhoseLightIsMapped) {
  World world = furnished_room();
  Ball in_the_air = world.balls[0];
  in_the_air.position_m = {2.0, 0.0, 0.5};
  world.balls.push_back(in_the_air);
  World empty = world;
  empty.obstacles.clear();
  empty.balls.clear();
  const CameraRenderer renderer(test::lens(LensModel::pinhole), world, {});
  const cv::Mat with = renderer.radiance({standing()});
  const cv::Mat without = CameraRenderer(renderer.camera(), empty, {}).radiance({standing()});
  for (const Eigen::Vector3d& center : {world.balls[0].position_m, in_the_air.position_m,
                                        world.obstacles[0].center_m, world.obstacles[1].center_m}) {
    const auto pixel = renderer.camera().project(standing().X_WC.inverse() * center);
    const int column = static_cast<int>(std::lround(pixel->x())),
              row = static_cast<int>(std::lround(pixel->y()));
    for (int side = -2; side <= 2; ++side) {
      const cv::Vec3f difference =
          with.at<cv::Vec3f>(row, column + side) - without.at<cv::Vec3f>(row, column + side);
      EXPECT_GT(cv::norm(difference), 0.05) << center.transpose();
    }
  }
}

TEST(Renderer, TheNearerOfTwoBallsCoversTheOther) {
  World world = test::dark_room();
  Ball near = test::white_ball({2, 0, 250}, 0.2), far = test::white_ball({4, 0, 250}, 0.2);
  far.material = test::luminous({1, 0, 0});
  for (const bool near_first : {true, false}) {
    world.balls = near_first ? std::vector<Ball>{near, far} : std::vector<Ball>{far, near};
    const cv::Scalar sum = cv::sum(
        CameraRenderer(test::lens(LensModel::pinhole), world, {}).radiance({{test::level_view(), 0}}));
    EXPECT_NEAR(sum[2], sum[0], 1e-3 * sum[0]);  // no red beside the white
  }
}

TEST(Renderer, MotionBlurIsTheMeanOfItsInstants) {
  World world = test::dark_room();
  Ball ball = test::white_ball({2, 0, 250}, 0.2);
  LinearMotion motion;
  motion.velocity_mps = {0, 1};
  ball.motion = motion;
  world.balls = {ball};
  const CameraRenderer renderer(test::lens(LensModel::pinhole), world, {});
  const CameraView early{test::level_view(), 0}, late{test::level_view(), 0.1};
  const cv::Mat mean = (renderer.radiance({early}) + renderer.radiance({late})) / 2;
  EXPECT_LT(cv::norm(renderer.radiance({early, late}), mean, cv::NORM_INF), 1e-6);
}

TEST(Renderer, ABallShadesTheFloorBesideIt) {
  const auto brightness_under = [](bool with_ball) {
    World world = furnished_room();
    world.room.floor.texture.pattern = Pattern::plain;
    world.obstacles.clear();
    if (!with_ball) world.balls.clear();
    const CameraRenderer renderer(test::lens(LensModel::pinhole), world, {});
    const cv::Mat light = renderer.radiance({standing()});
    const CameraView view = standing();
    // Beyond the contact point as the light sees it.
    const auto pixel = renderer.camera().project(view.X_WC.inverse() * Eigen::Vector3d(2.02, 0.02, 0.0));
    return light.at<cv::Vec3f>(static_cast<int>(pixel->y() + 0.5), static_cast<int>(pixel->x() + 0.5))[1];
  };
  EXPECT_LT(brightness_under(true), 0.7 * brightness_under(false));
}

TEST(Renderer, LightAddsUp) {
  World world = furnished_room();
  const auto light = [&](double lamp, double ambient) {
    world.lights[0].intensity = Rgb::Constant(lamp);
    world.ambient = Rgb::Constant(ambient);
    return CameraRenderer(test::lens(LensModel::pinhole), world, {}).radiance({standing()});
  };
  const cv::Mat sum = light(4, 0) + light(0, 0.3);
  EXPECT_LT(cv::norm(light(4, 0.3), sum, cv::NORM_INF), 1e-5);
  EXPECT_LT(cv::norm(light(8, 0.6), 2 * sum, cv::NORM_INF), 2e-5);
}

TEST(Renderer, FloorPatternsDoNotFlickerFarAway) {
  // A moving camera must see far checks as their mean: what changes from frame to frame stays small there.
  World world = furnished_room();
  world.obstacles.clear();
  world.balls.clear();
  world.room.floor.texture = {Pattern::checks, {0.9, 0.9, 0.9}, {0.1, 0.1, 0.1}, 0.1};
  const CameraRenderer renderer(test::lens(LensModel::pinhole), world, {});
  const cv::Mat a = renderer.radiance({standing(0)}), b = renderer.radiance({standing(0.05)});
  const auto horizon = renderer.camera().project(standing().X_WC.inverse() * Eigen::Vector3d(5.5, 0, 0));
  const int row = static_cast<int>(horizon->y());
  EXPECT_LT(cv::norm(a.row(row), b.row(row), cv::NORM_L1) / (3.0 * a.cols), 0.05);
}

TEST(Renderer, RefusesASensorThatCannotBe) {
  SensorOptions sensor;
  sensor.blur_px = -1;
  sensor.gamma = std::nan("");
  try {
    CameraRenderer(test::lens(LensModel::pinhole), test::dark_room(), sensor);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 2u);
  }
}

}  // namespace
}  // namespace ballservo
