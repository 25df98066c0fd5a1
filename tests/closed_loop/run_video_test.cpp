#include "app/experiment/run_video.hpp"

#include <gtest/gtest.h>

namespace ballservo {
namespace {

// Whether a robot there changes the view from above.
bool shows(const World& world, const Pose2& pose) {
  const TopView view(world, pioneer_3dx_footprint, {0, 0, 0}, Eigen::AlignedBox2d(Eigen::Vector2d(3, 0)), 0.8,
                     480);
  StepRecord step;
  step.p_WB = {3, 0, 0.06};
  step.pose = pose;
  StepRecord far_away = step;
  far_away.pose = {100, 100, 0};
  return cv::norm(view.draw({step}), view.draw({far_away}), cv::NORM_INF) > 0;
}

TEST(TopView, ShowsTheWayAroundWhatStandsNearTheStraightOne) {
  World world;
  const Pose2 beyond{1.5, 2.6, 0}, other_side{1.5, -2.6, 0};
  EXPECT_FALSE(shows(world, beyond));
  Obstacle column;
  column.shape = CylinderShape{0.2, 0.5};
  column.center_m = {1.5, 1.6, 0.25};
  world.obstacles.push_back(column);
  EXPECT_TRUE(shows(world, {1.5, 0, 0}));
  EXPECT_TRUE(shows(world, beyond));
  EXPECT_FALSE(shows(world, other_side));
  column.center_m = {6, 3, 0.25};  // far from the way
  world.obstacles = {column};
  EXPECT_FALSE(shows(world, beyond));
}

TEST(TopView, ShowsWhereverTheBallComesAndTheOtherBalls) {
  World world;
  Ball other;
  other.diameter_m = 0.2;
  other.position_m = {2, 0.5, 0.1};
  world.balls = {other};
  const Eigen::AlignedBox2d ball_floor(Eigen::Vector2d(2, -1), Eigen::Vector2d(5, 3));
  const TopView view(world, pioneer_3dx_footprint, {}, ball_floor, 0.8, 480);
  const auto drawn = [&view](double x_m, double y_m) {
    StepRecord step;
    step.p_WB = {x_m, y_m, 0.06};
    step.pose = {100, 100, 0};
    return view.draw({step});
  };
  EXPECT_GT(cv::norm(drawn(5, 3), drawn(5, -1), cv::NORM_INF), 0);
  const TopView empty({}, pioneer_3dx_footprint, {}, ball_floor, 0.8, 480);
  StepRecord step;
  step.pose = {100, 100, 0};
  EXPECT_GT(cv::norm(view.draw({step}), empty.draw({step}), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace ballservo
