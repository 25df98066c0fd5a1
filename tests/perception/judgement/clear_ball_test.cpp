// Discs and leaves of a ball's colour, alone and beside the ball.
#include "perception/judgement/clear_ball.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <string>

#include "calibration/base/random.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const Eigen::Vector2d ball_px(80, 120), other_px(230, 110);

Detector some_detector() { return test::detector_for(test::pinhole({320, 240}, 400)); }

cv::Mat blurred(const cv::Mat& bgr) {
  cv::Mat result;
  cv::GaussianBlur(bgr, result, {}, 0.7);
  return result;
}

bool is_found(const std::vector<BallObservation>& balls, const Eigen::Vector2d& center_px) {
  return std::any_of(balls.begin(), balls.end(), [&](const BallObservation& ball) {
    return (ball.outline.center_px - center_px).norm() < 3;
  });
}

TEST(ClearBall, WhatIsEvenlyBrightBesideItIsNoBall) {
  Detector detector = some_detector();
  for (const double radius_px : {13.0, 20.0, 40.0}) {
    cv::Mat disc = test::grey_picture();
    test::paint_disc(disc, other_px, radius_px, 0.8 * test::red);
    EXPECT_TRUE(is_found(detector.detect(blurred(disc)), other_px)) << "alone it may be one";

    cv::Mat two_discs = disc.clone();
    test::paint_disc(two_discs, ball_px, 30, test::red);
    EXPECT_EQ(detector.detect(blurred(two_discs)).size(), 2u);

    cv::Mat beside = disc.clone();
    test::paint_shaded_disc(beside, ball_px, 30, test::red);
    beside = blurred(beside);
    DetectionStages stages;
    const auto& balls = detector.detect(beside, {}, &stages);
    ASSERT_EQ(balls.size(), 1u);
    EXPECT_TRUE(is_found(balls, ball_px));
    ASSERT_EQ(stages.candidates.size(), 2u);
    for (const DetectionStages::Candidate& candidate : stages.candidates)
      EXPECT_EQ(candidate.reason,
                std::string(candidate.accepted ? "" : "evenly bright, beside a ball that is shaded"));
    EXPECT_EQ(detector.detect(beside, {{0, 0}, beside.size()}).size(), 1u) << "as a tracker looks";
    EXPECT_EQ(detector.detect(beside, {170, 50, 120, 120}).size(), 1u) << "not in the ball's company";

    cv::Mat green_ball = disc.clone();
    test::paint_shaded_disc(green_ball, ball_px, 30, test::green);
    EXPECT_TRUE(is_found(detector.detect(blurred(green_ball)), other_px)) << "of another class";
  }
}

TEST(ClearBall, ShadedAsItIsABallStays) {
  Detector detector = some_detector();
  for (const double radius_px : {5.0, 8.0, 20.0}) {
    cv::Mat bgr = test::grey_picture();
    test::paint_shaded_disc(bgr, ball_px, 30, test::red);
    test::paint_shaded_disc(bgr, other_px, radius_px, test::red);
    EXPECT_EQ(detector.detect(blurred(bgr)).size(), 2u) << radius_px;
  }
}

TEST(ClearBall, ALeafBesideItMustBeSurer) {
  Detector detector = some_detector();
  int alone = 0, beside = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    RandomEngine engine = random_stream(seed, "leaf");
    const Eigen::Rotation2Dd turn(uniform(engine, 0, 3));
    const double length_px = uniform(engine, 4, 6), width_px = uniform(engine, 0.8, 1) * length_px;
    cv::Mat bgr = test::grey_picture();
    test::paint(bgr, 0.6 * test::red, [&](const Eigen::Vector2d& p) {
      const Eigen::Vector2d q = turn * (p - other_px);
      return std::hypot(q.x() / length_px, q.y() / width_px) < 1;
    });
    alone += is_found(detector.detect(blurred(bgr)), other_px);
    test::paint_shaded_disc(bgr, ball_px, 30, test::red);
    beside += is_found(detector.detect(blurred(bgr)), other_px);
  }
  EXPECT_GE(alone, 8);
  EXPECT_LT(3 * beside, alone);
}

}  // namespace
}  // namespace ballservo
