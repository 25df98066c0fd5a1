// Balls in much noise.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibration/base/random.hpp"
#include "perception/detector.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};

// Nearly half of its pixels leave the class.
TEST(NoisyPicture, ShowsAPaleBall) {
  Detector detector = test::detector_for(test::pinhole(size, 400));
  int found = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    RandomEngine engine = random_stream(seed, "noisy_picture_test");
    cv::Mat bgr = test::grey_picture();
    test::paint_shaded_disc(bgr, {160, 120}, 30, {55, 55, 150});
    test::add_noise(bgr, 18, engine);
    const auto& balls = detector.detect(bgr);
    if (balls.empty()) continue;
    ++found;
    EXPECT_EQ(balls.size(), 1u);
    EXPECT_LT((balls[0].outline.center_px - Eigen::Vector2d(160, 120)).norm(), 1) << seed;
  }
  EXPECT_EQ(found, 10);
}

// Of the pixels of a disc, in noise that is nothing to a vivid class.
TEST(NoisyPicture, TellsAPaleClassInLessNoise) {
  const auto told = [](double chroma, BallFit fit) {
    DetectorOptions options;
    options.fit = fit;
    ColorTable colors = *test::red_and_green();
    const auto cell = static_cast<std::size_t>(chroma / ChromaHistogram::cell) + ChromaHistogram::side / 2;
    colors.classes[0].histogram.counts[ChromaHistogram::side / 2 * ChromaHistogram::side + cell] = 1000;
    Detector detector(std::make_shared<const RayTable>(test::pinhole(size, 400)),
                      std::make_shared<const ColorTable>(colors), options);
    RandomEngine engine = random_stream(1, "noisy_picture_test");
    cv::Mat bgr = test::grey_picture();
    test::paint_disc(bgr, {160, 120}, 30, {68, 68, 146});
    test::add_noise(bgr, 5, engine);
    DetectionStages stages;
    detector.detect(bgr, {}, &stages);
    return cv::countNonZero(stages.classified) / (M_PI * 30 * 30);
  };
  const double vivid = told(60, BallFit::sphere);
  EXPECT_GT(told(15, BallFit::sphere), vivid + 0.1);
  EXPECT_EQ(told(15, BallFit::paper), vivid);  // whose circle is voted from the boundary as it is
}

TEST(NoisyPicture, SaysHowCoarselyToLookAtBalls) {
  RandomEngine engine = random_stream(1, "noisy_picture_test");
  cv::Mat bgr(size.height_px, size.width_px, CV_8UC3, cv::Scalar(75, 75, 130));
  test::paint_shaded_disc(bgr, {160, 120}, 26, {55, 55, 150});
  cv::GaussianBlur(bgr, bgr, {}, 2);
  test::add_noise(bgr, 10, engine);
  BallObservation ball;
  ball.color_class = 1;
  ball.outline.center_px = {160, 120};
  ball.outline.radius_px = 26;
  Detector fresh = test::detector_for(test::pinhole(size, 400)),
           knows = test::detector_for(test::pinhole(size, 400));
  knows.detect(bgr);
  EXPECT_GT(knows.log_odds(bgr, ball), fresh.log_odds(bgr, ball) + 3);
}

}  // namespace
}  // namespace ballservo
