// Pictures made to be slow: what a detector leaves out of them, and that it says so.
#include <gtest/gtest.h>

#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};

/// Squares of a ball's colour, all over the picture.
cv::Mat pattern(ImageSize of, int side_px, int pitch_px) {
  cv::Mat bgr = test::grey_picture(of.width_px, of.height_px);
  for (int v = 1; v + side_px < of.height_px; v += pitch_px) {
    for (int u = 1; u + side_px < of.width_px; u += pitch_px)
      cv::rectangle(bgr, cv::Rect(u, v, side_px, side_px), cv::Scalar(test::red), cv::FILLED);
  }
  return bgr;
}

/// Balls of radius 6 to 17 px, each its own region.
cv::Mat twelve_balls(cv::Mat bgr = test::grey_picture()) {
  for (int i = 0; i < 12; ++i) {
    const cv::Point center(35 + 75 * (i % 4), 40 + 75 * (i / 4));
    cv::circle(bgr, center, 14 + i, test::grey, cv::FILLED);
    test::paint_shaded_disc(bgr, {center.x, center.y}, 6.0 + i, test::red);
  }
  return bgr;
}

TEST(DetectionLimits, TheLargestRegionsAreSearched) {
  Detector detector = test::detector_for(long_lens_camera(size));
  const auto& balls = detector.detect(twelve_balls(pattern(size, 5, 10)));
  EXPECT_EQ(balls.size(), 12u);
  EXPECT_GT(detector.left_out().regions, 100);
  EXPECT_EQ(detector.left_out().shorter_px, 0);
  detector.detect(test::grey_picture());
  EXPECT_FALSE(detector.left_out());
}

TEST(DetectionLimits, NothingIsLeftOutOfAnOrdinaryPicture) {
  Detector detector = test::detector_for(long_lens_camera(size));
  EXPECT_EQ(detector.detect(twelve_balls()).size(), 12u);
  EXPECT_FALSE(detector.left_out());
}

// One ball is followed by its own surroundings; only looks at the whole picture meet the pattern.
TEST(DetectionLimits, ATrackersPictureIsAsLeftOutAsItsOwnLooks) {
  Tracker tracker(test::detector_for(long_lens_camera(size)));
  cv::Mat bgr = pattern(size, 5, 10);
  test::paint_shaded_disc(bgr, {160, 120}, 17, test::red);
  for (int picture = 0; picture <= newcomers_every; ++picture) {
    tracker.update(bgr, picture / 30.0);
    EXPECT_EQ(tracker.left_out().regions > 0, picture % newcomers_every == 0) << picture;
  }
}

TEST(DetectionLimits, ABallIsFoundInAPatternOfItsColour) {
  constexpr ImageSize large{1280, 960};
  cv::Mat bgr = pattern(large, 3, 8);
  cv::circle(bgr, {640, 480}, 50, cv::Scalar(120, 120, 120), cv::FILLED);
  test::paint_disc(bgr, {640, 480}, 40, test::red);
  Detector detector = test::detector_for(long_lens_camera(large));
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_NEAR(balls[0].outline.radius_px, 40, 0.1);
  EXPECT_GT(detector.left_out().shorter_px, 0);
}

}  // namespace
}  // namespace ballservo
