// Pictures made to be slow: what a detector leaves out of them, and that it says so.
#include <gtest/gtest.h>

#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};

Detector limited_detector(int max_regions, int max_runs) {
  DetectorOptions options;
  options.max_regions = max_regions;
  options.max_runs = max_runs;
  return Detector(std::make_shared<const RayTable>(long_lens_camera(size)), test::red_and_green(), options);
}

/// Balls of radius 6 to 17 px, each its own region.
cv::Mat twelve_balls() {
  cv::Mat bgr = test::grey_picture();
  for (int i = 0; i < 12; ++i)
    test::paint_shaded_disc(bgr, {35.0 + 75 * (i % 4), 40.0 + 75 * (i / 4)}, 6.0 + i, test::red);
  return bgr;
}

TEST(DetectionLimits, TheLargestRegionsAreSearched) {
  Detector detector = limited_detector(4, 1 << 16);
  const auto& balls = detector.detect(twelve_balls());
  EXPECT_EQ(balls.size(), 4u);
  for (const BallObservation& ball : balls) EXPECT_GT(ball.outline.radius_px, 13);
  EXPECT_EQ(detector.left_out().regions, 8);
  EXPECT_EQ(detector.left_out().shorter_px, 0);
  detector.detect(test::grey_picture());
  EXPECT_FALSE(detector.left_out());
}

TEST(DetectionLimits, NothingIsLeftOutOfAnOrdinaryPicture) {
  Detector detector = limited_detector(12, 1 << 16);
  EXPECT_EQ(detector.detect(twelve_balls()).size(), 12u);
  EXPECT_FALSE(detector.left_out());
}

// One ball is followed by its own surroundings; only looks at the whole picture meet the other balls.
TEST(DetectionLimits, ATrackersPictureIsAsLeftOutAsItsOwnLooks) {
  Tracker tracker(limited_detector(1, 1 << 16));
  const cv::Mat bgr = twelve_balls();
  const int every = TrackerOptions{}.newcomers_every;
  for (int picture = 0; picture <= every; ++picture) {
    tracker.update(bgr, picture / 30.0);
    EXPECT_EQ(tracker.left_out().regions, picture % every == 0 ? 11 : 0) << picture;
  }
}

TEST(DetectionLimits, ABallIsFoundInAPatternOfItsColour) {
  cv::Mat bgr = test::grey_picture();
  for (int v = 0; v + 4 < size.height_px; v += 9) {
    for (int u = 0; u + 4 < size.width_px; u += 9)
      cv::rectangle(bgr, cv::Rect(u, v, 4, 4), cv::Scalar(40, 40, 210), cv::FILLED);
  }
  cv::circle(bgr, {160, 120}, 50, cv::Scalar(120, 120, 120), cv::FILLED);
  test::paint_disc(bgr, {160, 120}, 40, test::red);
  Detector detector = limited_detector(256, 2000);
  const auto& balls = detector.detect(bgr);
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_NEAR(balls[0].outline.radius_px, 40, 0.1);
  EXPECT_GT(detector.left_out().shorter_px, 0);
}

}  // namespace
}  // namespace ballservo
