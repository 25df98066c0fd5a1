// What tells a ball from what is nearly one, at any size.
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/teaching/ball_evidence.hpp"
#include "calibration/teaching/chroma_picture.hpp"
#include "calibration/teaching/round_regions.hpp"
#include "tests/calibration/color_pictures.hpp"

namespace ballservo {
namespace {

using namespace test;

/// A regular polygon around (160, 120), drawn four times as large and reduced, as a lens would see it.
cv::Mat polygon(int corners, double radius_px) {
  constexpr int fine = 4;
  cv::Mat large(240 * fine, 320 * fine, CV_8UC3, cv::Scalar(140, 140, 140)), result;
  std::vector<cv::Point> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * CV_PI * (i + 0.3) / corners;
    outline.emplace_back(cvRound(fine * (160 + radius_px * std::cos(angle))),
                         cvRound(fine * (120 + radius_px * std::sin(angle))));
  }
  cv::fillPoly(large, std::vector{outline}, {40, 40, 190});
  cv::resize(large, result, {320, 240}, 0, 0, cv::INTER_AREA);
  add_noise(result, 2, 4);
  return result;
}

BallEvidence evidence_at(const cv::Mat& picture, double radius_px) {
  const cv::Mat3f lab = lab_image(picture);
  const cv::Vec3f c = lab(120, 160);
  return ball_evidence(lab, {{160, 120}, radius_px}, {c[0], c[1], c[2]});
}

TEST(BallEvidence, SquaresAndHexagonsAreTellablyNoCircles) {
  for (const double radius_px : {6.0, 9.0, 12.0, 30.0}) {
    const double circle = evidence_at(polygon(90, radius_px), radius_px).contour;
    EXPECT_LT(evidence_at(polygon(4, 1.2 * radius_px), radius_px).contour, circle - 0.5) << radius_px;
    EXPECT_LT(evidence_at(polygon(3, 1.3 * radius_px), radius_px).contour, circle - 0.5) << radius_px;
  }
  for (const double radius_px : {12.0, 30.0}) {
    const double circle = evidence_at(polygon(90, radius_px), radius_px).contour;
    EXPECT_LT(evidence_at(polygon(6, 1.07 * radius_px), radius_px).contour, circle - 0.5) << radius_px;
  }
}

TEST(BallEvidence, TheShadingOfASphereSpeaksForABall) {
  cv::Mat ball = grey_picture();
  draw_shaded_ball(ball, 160, 120, 25, red_paint);
  const BallEvidence round = evidence_at(ball, 25), flat = evidence_at(polygon(90, 25), 25);
  EXPECT_GT(round.shading, 0.9);
  EXPECT_GT(round.relief, 0.15);
  EXPECT_LT(flat.relief, 0.03);
  EXPECT_GT(round.log_odds(), flat.log_odds() + 4);
}

TEST(BallEvidence, ARoughCircleIsDrawnToTheRim) {
  cv::Mat ball = grey_picture();
  draw_shaded_ball(ball, 163.3, 117.6, 25, green_paint);
  const BallEvidence e = evidence_at(ball, 21);
  EXPECT_LT((e.center_px - Eigen::Vector2d(163.3, 117.6)).norm(), 0.3);
  EXPECT_NEAR(e.radius_px, 25, 0.6);
}

TEST(BallEvidence, HalfABallBehindASheetIsStillABall) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160, 120, 30, yellow_paint);
  cv::rectangle(picture, cv::Rect(165, 0, 60, 240), {120, 60, 60}, cv::FILLED);
  add_noise(picture, 2, 4);
  const std::vector<RoundRegion> regions = find_round_regions(picture).regions;
  ASSERT_FALSE(regions.empty());
  EXPECT_LT((regions[0].center_px - Eigen::Vector2d(160, 120)).norm(), 1);
  EXPECT_NEAR(regions[0].radius_px, 30, 1);
  EXPECT_GT(regions[0].evidence.log_odds(), 2);
}

TEST(BallEvidence, ABallBeforeAWallOfItsHueIsFoundByItsLightness) {
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(150, 200, 140));
  draw_shaded_ball(picture, 160, 120, 20, 0.4 * Eigen::Vector3d(0.3, 0.58, 0.26));
  add_noise(picture, 2, 4);
  const std::vector<RoundRegion> regions = find_round_regions(picture).regions;
  ASSERT_FALSE(regions.empty());
  EXPECT_LT((regions[0].center_px - Eigen::Vector2d(160, 120)).norm(), 1);
}

}  // namespace
}  // namespace ballservo
