#include "app/experiment/run_video.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "app/scenario/scenario.hpp"
#include "tests/support/test_data.hpp"

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

TEST(TopView, DrawsTheSonarsConesAsWideAsTheyAre) {
  const auto drawn = [](double half_angle_rad) {
    SonarBeam beam;
    beam.half_angle_rad = half_angle_rad;
    const TopView view({}, pioneer_3dx_footprint, {}, Eigen::AlignedBox2d(Eigen::Vector2d(3, 0)), 0.8, 480,
                       beam);
    StepRecord step;
    step.p_WB = {3, 0, 0.06};
    SonarFiring ahead;
    ahead.reading.transducer = 3;
    ahead.reading.range_m = 2;
    cv::Mat changed;
    cv::absdiff(view.draw({step}, {ahead}), view.draw({step}), changed);
    return cv::countNonZero(changed.reshape(1));
  };
  EXPECT_GT(drawn(0.4), 1.5 * drawn(0.2));
}

// Whether the ball is drawn into a picture that was black.
bool is_drawn(const cv::Mat& picture) {
  cv::Mat magenta;
  cv::inRange(picture, cv::Scalar(200, 0, 200), cv::Scalar(255, 60, 255), magenta);
  return cv::countNonZero(magenta) > 20;
}

TEST(PictureKeeper, DrawsWhatItKeepsOfPicturesThatAreGoneAfterwards) {
  const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "static_ball.yaml", {}, 0);
  const ImageSize size = scenario.camera.camera.size();
  cv::Mat buffer(size.height_px, size.width_px, CV_8UC3);  // of a camera that uses it again
  CameraFrame frame;
  frame.bgr = buffer;
  Percept percept;
  percept.ball.state = TrackState::confirmed;
  percept.ball.p_CB = {0, 0, 1};
  int shown = 0;
  PictureKeeper silent(scenario), showing(scenario, [&](const cv::Mat&picture) {
    EXPECT_TRUE(is_drawn(picture));
    ++shown;
  });
  for (int k = 0; k < 3; ++k) {
    frame.time_s = percept.ball.time_s = 0.1 * k;
    for (PictureKeeper* const keeper : {&silent, &showing}) {
      buffer.setTo(0);
      keeper->frame({frame, percept, 0, 0});
      EXPECT_EQ(cv::countNonZero(buffer.reshape(1)), 0);
      buffer.setTo(255);
    }
  }
  EXPECT_EQ(shown, 3);
  const std::vector<KeyFrame> kept = silent.finish();
  ASSERT_EQ(kept.size(), 2u);  // the first one and the last one
  for (const KeyFrame& key_frame : kept) EXPECT_TRUE(is_drawn(key_frame.picture)) << key_frame.caption;
  EXPECT_EQ(kept.back().time_s, 0.2);
  EXPECT_EQ(kept.back().picture.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
}

}  // namespace
}  // namespace ballservo
