// What is an oval and yet a ball, and what is not.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "perception/detector.hpp"
#include "perception/judgement/ball_judge.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

/// A ball, shaded or flat, in a picture that was made so much narrower.
cv::Mat narrowed_ball(double radius_px, double factor, bool shaded = true) {
  cv::Mat bgr = test::grey_picture(static_cast<int>(320 * factor));
  const auto paint = shaded ? test::paint_shaded_disc : test::paint_disc;
  paint(bgr, {150 * factor, 110}, radius_px, test::red);
  cv::Mat narrowed;
  cv::resize(bgr, narrowed, {320, 240}, 0, 0, cv::INTER_AREA);
  return narrowed;
}

TEST(Oval, ALensThatIsNotQuiteTheStatedOneMakesNoBallDoubtful) {
  for (const double radius_px : {25.0, 50.0}) {
    Detector detector = test::detector_for(test::pinhole({320, 240}, 400), 0.05);
    const auto& balls = detector.detect(narrowed_ball(radius_px, 1.06));
    ASSERT_EQ(balls.size(), 1u);
    EXPECT_GE(balls[0].quality, doubtful_quality) << radius_px;
    EXPECT_NEAR(balls[0].outline.radius_px, radius_px / std::sqrt(1.06), 0.01 * radius_px);
  }
}

// The edge of what stands close behind a ball bulges its outline on one side, as no lens does.
TEST(Oval, AThingCloseBehindMakesNoOvalOfABall) {
  struct Behind {
    double left_px, larger_px;
  };
  for (const auto& [left_px, larger_px] : {Behind{1.5, 0}, Behind{2, -0.5}, Behind{2, 0}}) {
    Detector detector = test::detector_for(test::pinhole({320, 240}, 400), 0.05);
    cv::Mat bgr(240, 320, CV_8UC3, cv::Scalar(170, 150, 60));
    const Eigen::Vector2d center_px(150, 110);
    test::paint_disc(bgr, center_px + Eigen::Vector2d(-left_px, 1.5), 25 + larger_px, {40, 45, 50});
    test::paint_shaded_disc(bgr, center_px, 25, test::red);
    cv::GaussianBlur(bgr, bgr, {}, 0.7);
    const auto& balls = detector.detect(bgr);
    ASSERT_EQ(balls.size(), 1u);
    EXPECT_NEAR(balls[0].outline.radius_px, 25, 0.15) << left_px;
    EXPECT_LT((balls[0].outline.center_px - center_px).norm(), 0.15) << left_px;
  }
}

TEST(Oval, NoLensMakesABallOfAnOval) {
  for (const double factor : {1.12, 1.2}) {
    Detector detector = test::detector_for(test::pinhole({320, 240}, 400), 0.05);
    for (const BallObservation& ball : detector.detect(narrowed_ball(50, factor)))
      EXPECT_LT(ball.quality, 0.8) << factor;
  }
}

// A lens that is not known makes ovals of balls; so does motion.
TEST(Oval, AnOvalThatIsFlatIsADiscSeenAslant) {
  for (const double radius_px : {20.0, 30.0, 45.0}) {
    for (const double factor : {1.08, 1.12, 1.16}) {
      for (const double oval_fraction : {0.0, 0.04}) {
        DetectorOptions options;
        options.oval_fraction = oval_fraction;
        Detector detector(std::make_shared<const RayTable>(test::pinhole({320, 240}, 400)),
                          test::red_and_green(), options);
        const auto balls = [&](bool shaded) {
          const cv::Mat bgr = narrowed_ball(radius_px, factor, shaded);
          return detector.detect(bgr).size() + detector.detect_thoroughly(bgr).size();
        };
        const bool may_be_ball = factor < 1.1 || oval_fraction > 0;
        EXPECT_EQ(balls(false), 0u) << radius_px << " " << factor << " " << oval_fraction;
        EXPECT_GE(balls(true), may_be_ball ? 1u : 0u) << radius_px << " " << factor << " " << oval_fraction;
      }
    }
  }
}

TEST(Oval, AFlatBallIsFoundWhereItIsExpectedEvenIfItIsAnOval) {
  Detector detector = test::detector_for(test::pinhole({320, 240}, 400));
  const Eigen::Vector3d ray = Eigen::Vector3d(150 - 159.5, 110 - 119.5, 400).normalized();
  const ExpectedBall expected{1, {ray, std::atan(30 / 400.0)}, 12};
  const auto ball = detector.find_expected(narrowed_ball(30, 1.08, false), {0, 0, 320, 240}, expected, true,
                                           [](const BallObservation&) { return true; });
  EXPECT_TRUE(ball);
}

}  // namespace
}  // namespace ballservo
