#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/teaching/box_trainer.hpp"
#include "tests/calibration/color_pictures.hpp"

namespace ballservo {
namespace {

using namespace test;

/// A ball (or none for radius 0) before a grey wall with a square of another colour.
cv::Mat frame(double cx, double cy, double radius, const Eigen::Vector3d& paint, int index) {
  cv::Mat picture = grey_picture();
  cv::rectangle(picture, cv::Rect(250, 10, 60, 60), {200, 80, 20}, cv::FILLED);
  if (radius > 0) draw_shaded_ball(picture, cx, cy, radius, paint);
  add_noise(picture, 2, static_cast<std::uint64_t>(index));
  return picture;
}

const PointedBall box{{160, 120}, 36};

TEST(BoxTrainer, LearnsFromFramesAndFollowsTheDrift) {
  BoxTrainer trainer("target", box);
  int frames = 0;
  for (int i = 0; i < 60 && !trainer.enough(); ++i, ++frames) {
    if (i < 5) {
      EXPECT_FALSE(trainer.look(frame(0, 0, 0, red_paint, i), i));  // not there yet
    } else {
      EXPECT_TRUE(trainer.look(frame(150 + 2 * i, 120 - i, 30, red_paint, i), i)) << i;
    }
  }
  EXPECT_EQ(frames, 35);
  const LearntColors colors = trainer.finish();
  ASSERT_EQ(colors.table.classes.size(), 1u);
  EXPECT_EQ(colors.table.classes[0].name, "target");
  const std::vector<LearntCircle>& circles = colors.circles.at("target");
  ASSERT_EQ(circles.size(), 30u);
  for (int k = 0; k < 30; ++k) {
    EXPECT_EQ(circles[k].frame, k + 5);
    EXPECT_LT((circles[k].center_px - Eigen::Vector2d(150 + 2 * (k + 5), 120 - (k + 5))).norm(), 1.5) << k;
    EXPECT_NEAR(circles[k].radius_px, 30, 2);
  }
  const cv::Mat other = frame(100, 150, 40, red_paint, 99);
  const auto index = [&](int x, int y) {
    const cv::Vec3b& c = other.at<cv::Vec3b>(y, x);
    return colors.table.classify(c[0], c[1], c[2]);
  };
  EXPECT_EQ(index(100, 150), 1);
  EXPECT_EQ(index(95, 140), 1);
  EXPECT_EQ(index(280, 40), no_class);
  EXPECT_EQ(index(20, 20), no_class);
}

TEST(BoxTrainer, SamplesAreThoseOfWholeFrames) {
  // A box far larger than where the ball is looked at in full: what is learnt is the ball, wherever the crop
  // lies.
  BoxTrainer near_border("target", {{20, 20}, 36});
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(near_border.look(frame(34, 33, 30, green_paint, i), i));
  EXPECT_LT((near_border.finish().circles.at("target")[0].center_px - Eigen::Vector2d(34, 33)).norm(), 1.5);
}

TEST(BoxTrainer, TooFewFramesAreRefusedWithFigures) {
  BoxTrainer trainer("target", box);
  for (int i = 0; i < 14; ++i) trainer.look(frame(160, 120, i < 4 ? 30 : 0, red_paint, i), i);
  try {
    trainer.finish();
    FAIL();
  } catch (const Refusal& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("only 4 of 14 frames"), std::string::npos) << refusal.what();
  }
}

TEST(BoxTrainer, ABallElsewhereIsNotTheOneInTheBox) {
  BoxTrainer trainer("target", box);
  EXPECT_FALSE(trainer.look(frame(60, 60, 30, red_paint, 1), 1));
  EXPECT_FALSE(trainer.look(frame(160, 120, 8, red_paint, 2), 2));  // much smaller than the box
}

TEST(BoxTrainer, ThingsOfDifferentColorsAreRefused) {
  BoxTrainer trainer("target", box);
  for (int i = 0; i < 10; ++i) trainer.look(frame(160, 120, 30, i % 2 ? red_paint : green_paint, i), i);
  EXPECT_THROW(trainer.finish(), Refusal);
}

TEST(BoxTrainer, BadBoxesAreFaults) {
  const auto trainer = [](const std::string& name, double x, double y, double r) {
    return BoxTrainer(name, {{x, y}, r});
  };
  EXPECT_THROW(trainer("Bad name", 160, 120, 30), InputError);
  EXPECT_THROW(trainer("a", std::nan(""), 120, 30), InputError);
  EXPECT_THROW(trainer("a", 160, 120, 0), InputError);
  BoxTrainer outside = trainer("a", 400, 120, 30);
  EXPECT_THROW(outside.look(frame(160, 120, 30, red_paint, 1), 1), InputError);
  BoxTrainer sizes = trainer("a", 160, 120, 30);
  sizes.look(frame(160, 120, 30, red_paint, 1), 1);
  EXPECT_THROW(sizes.look(cv::Mat(100, 400, CV_8UC3, cv::Scalar(1, 2, 3)), 2), InputError);
}

}  // namespace
}  // namespace ballservo
