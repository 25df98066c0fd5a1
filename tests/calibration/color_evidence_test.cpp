// What tells a ball from what is nearly one, at any size.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/circles/circle_evidence.hpp"
#include "calibration/teaching/chroma_picture.hpp"
#include "calibration/teaching/circle_seeds.hpp"
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

CircleEvidence evidence_at(const cv::Mat& picture, double radius_px) {
  const cv::Mat3f lab = lab_image(picture);
  const cv::Vec3f c = lab(120, 160);
  return circle_evidence(lab, {{160, 120}, radius_px}, {c[0], c[1], c[2]});
}

TEST(CircleEvidence, SquaresAndHexagonsAreTellablyNoCircles) {
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

TEST(CircleEvidence, TheShadingOfASphereSpeaksForABall) {
  cv::Mat ball = grey_picture();
  draw_shaded_ball(ball, 160, 120, 25, red_paint);
  const CircleEvidence round = evidence_at(ball, 25), flat = evidence_at(polygon(90, 25), 25);
  EXPECT_GT(round.shading, 0.9);
  EXPECT_GT(round.relief, 0.15);
  EXPECT_LT(flat.relief, 0.03);
  EXPECT_GT(round.log_odds(), flat.log_odds() + 4);
}

TEST(CircleEvidence, AnOverexposedBallIsShadedStill) {
  for (const Eigen::Vector3d& paint : {yellow_paint, green_paint}) {
    const auto sphere = [&](double ambient) {
      cv::Mat picture = grey_picture();
      draw_shaded_ball(picture, 160, 120, 25, paint, ambient);
      picture.convertTo(picture, -1, 2.2);
      return evidence_at(picture, 25).sphere();
    };
    EXPECT_GT(sphere(0.5), 0.5) << paint;
    EXPECT_LT(sphere(1), 0.1) << paint << ", flat";
  }
}

TEST(CircleEvidence, ADullBallIsAsLikelyWhereItsColourIsKnown) {
  const auto ball_of = [](const Eigen::Vector3d& paint) {
    cv::Mat ball = grey_picture();
    draw_shaded_ball(ball, 160, 120, 25, paint);
    return evidence_at(ball, 25);
  };
  const CircleEvidence dull = ball_of({0.1, 0.16, 0.1}), vivid = ball_of(green_paint);
  EXPECT_LT(dull.log_odds(), vivid.log_odds() - 3);
  EXPECT_GT(dull.log_odds_of_known_color(), vivid.log_odds_of_known_color() - 1.5);
}

TEST(CircleEvidence, ARoughCircleIsDrawnToTheRim) {
  cv::Mat ball = grey_picture();
  draw_shaded_ball(ball, 163.3, 117.6, 25, green_paint);
  const CircleEvidence e = evidence_at(ball, 21);
  EXPECT_LT((e.center_px - Eigen::Vector2d(163.3, 117.6)).norm(), 0.3);
  EXPECT_NEAR(e.radius_px, 25, 0.6);
}

TEST(CircleEvidence, HalfABallBehindASheetIsStillABall) {
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

/// A pale ball with white stripes, of the wall's lightness, in a hand: fingers lie over a third of its rim.
cv::Mat striped_ball_in_a_hand() {
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(150, 156, 160));
  const cv::Scalar skin(95, 105, 165);
  cv::ellipse(picture, {230, 150}, {90, 45}, 25, 0, 360, skin, cv::FILLED, cv::LINE_AA);
  draw_shaded_ball(picture, 160, 120, 50, {0.35, 0.5, 0.38}, 0.6);
  for (int y = 70; y < 170; ++y) {
    for (int x = 110; x < 210; ++x) {
      const double side = (x - 160) * 0.3 + (y - 120);
      if (std::hypot(x - 160, y - 120) < 49.5 && side > -35 && side < -12)
        picture.at<cv::Vec3b>(y, x) = cv::Vec3b(168, 178, 172);
    }
  }
  for (const double angle : {0.6, 2.6}) {
    const cv::Point at(cvRound(160 + 52 * std::cos(angle)), cvRound(120 + 52 * std::sin(angle)));
    cv::ellipse(picture, at, {18, 10}, angle * 180 / CV_PI + 70, 0, 360, skin, cv::FILLED, cv::LINE_AA);
  }
  cv::GaussianBlur(picture, picture, {}, 1.5);
  add_noise(picture, 2, 4);
  return picture;
}

// A leaf, a sleeve: shaded as a sphere, of a colour that is nowhere else, and round to a fifth.
TEST(CircleEvidence, AShadedThingWithoutACirclesRimIsNoBall) {
  const cv::Mat ground = grey_picture();
  cv::Mat leaf = ground.clone();
  draw_shaded_ball(leaf, 160, 120, 60, yellow_paint);
  for (int y = 60; y <= 180; ++y) {
    for (int x = 100; x <= 220; ++x) {
      const double angle = std::atan2(y - 120, x - 160);
      if (std::hypot(x - 160, y - 120) > 40 * (1 + 0.2 * std::cos(3 * angle) + 0.15 * std::sin(5 * angle)))
        leaf.at<cv::Vec3b>(y, x) = ground.at<cv::Vec3b>(y, x);
    }
  }
  cv::GaussianBlur(leaf, leaf, {}, 1);
  const CircleEvidence e = evidence_at(leaf, 40);
  EXPECT_GT(e.sphere(), 0.5);
  EXPECT_GT(e.distinct, 0.7);
  EXPECT_LT(e.log_odds(), -1) << e.contour;
}

TEST(CircleEvidence, NothingHidesHalfADisc) {
  // The same half: behind a sheet, and cut off before the ground that lies around it.
  const cv::Mat ground = grey_picture();
  cv::Mat ball = ground.clone();
  draw_shaded_ball(ball, 160, 120, 25, red_paint);
  const cv::Rect right(166, 60, 80, 120);
  cv::Mat hidden = ball.clone(), cut = ball.clone();
  hidden(right).setTo(cv::Scalar(60, 90, 70));
  ground(right).copyTo(cut(right));
  const CircleEvidence of_hidden = evidence_at(hidden, 25), of_cut = evidence_at(cut, 25);
  EXPECT_GT(of_hidden.hidden_by, 0.8);
  EXPECT_LT(of_cut.hidden_by, 0.1);
  EXPECT_EQ(evidence_at(ball, 25).hidden_by, 1);
  EXPECT_GT(of_hidden.log_odds(), of_cut.log_odds() + 10);
}

TEST(CircleEvidence, FingersAndStripesHideNoBall) {
  const std::vector<RoundRegion> regions = find_round_regions(striped_ball_in_a_hand()).regions;
  ASSERT_FALSE(regions.empty());
  EXPECT_LT((regions[0].center_px - Eigen::Vector2d(160, 120)).norm(), 3);
  EXPECT_NEAR(regions[0].radius_px, 50, 3);
  EXPECT_GT(regions[0].evidence.log_odds(), 2);
}

TEST(RoundRegions, WhatGoesOnBeyondThePictureIsNoSmearedBall) {
  const auto smeared = [](int y) {
    cv::Mat picture = grey_picture();
    cv::ellipse(picture, {160, y}, {35, 60}, 0, 0, 360, {60, 90, 170}, cv::FILLED);
    cv::GaussianBlur(picture, picture, {}, 4);
    add_noise(picture, 2, 4);
    const std::vector<RoundRegion> regions = find_round_regions(picture).regions;
    return std::any_of(regions.begin(), regions.end(), [](const RoundRegion& r) { return r.smeared; });
  };
  EXPECT_TRUE(smeared(120));
  EXPECT_FALSE(smeared(200));
}

TEST(CircleEvidence, ARimMetBeyondTheCircleIsNotHidden) {
  // Both have half a circle's rim. A sheet hides the other half of the one; the other goes on as an arm does.
  cv::Mat hidden = grey_picture(), arm = grey_picture();
  cv::circle(hidden, {160, 120}, 30, {40, 40, 190}, cv::FILLED, cv::LINE_AA);
  cv::circle(arm, {160, 120}, 30, {40, 40, 190}, cv::FILLED, cv::LINE_AA);
  cv::rectangle(hidden, cv::Rect(160, 0, 160, 240), {120, 60, 60}, cv::FILLED);
  cv::rectangle(arm, cv::Rect(160, 90, 38, 61), {40, 40, 190}, cv::FILLED);
  const cv::Mat3f lab = lab_image(hidden), other = lab_image(arm);
  const cv::Vec3f c = lab(120, 150);
  const Eigen::Vector3d red(c[0], c[1], c[2]);
  const Outline circle{{160, 120}, 30};
  EXPECT_GT(circle_evidence(lab, circle, red).contour, circle_evidence(other, circle, red).contour + 0.1);
}

TEST(CircleEvidence, WhatIsLikeItsSurroundingsIsHardlyABall) {
  cv::Mat alone = grey_picture(), among(240, 320, CV_8UC3);
  draw_shaded_ball(alone, 160, 120, 25, red_paint);
  for (int y = 0; y < 240; y += 12)
    for (int x = 0; x < 320; x += 12)
      cv::rectangle(among, cv::Rect(x, y, 12, 12),
                    (x + y) / 12 % 2 ? cv::Scalar(40, 40, 190) : cv::Scalar(140, 140, 140), cv::FILLED);
  EXPECT_GT(evidence_at(alone, 25).distinct, 0.9);
  EXPECT_LT(evidence_at(among, 25).distinct, 0.4);
}

TEST(CircleEvidence, ABallBeforeAWallOfItsHueIsFoundByItsLightness) {
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(150, 200, 140));
  draw_shaded_ball(picture, 160, 120, 20, 0.4 * Eigen::Vector3d(0.3, 0.58, 0.26));
  add_noise(picture, 2, 4);
  const std::vector<RoundRegion> regions = find_round_regions(picture).regions;
  ASSERT_FALSE(regions.empty());
  EXPECT_LT((regions[0].center_px - Eigen::Vector2d(160, 120)).norm(), 1);
}

TEST(CircleSeeds, EveryBallIsAmongTheFirst) {
  cv::Mat picture = grey_picture();
  const std::vector<Eigen::Vector3d> balls{{60, 60, 6}, {120, 170, 12}, {230, 90, 60}};
  for (const Eigen::Vector3d& ball : balls)
    draw_shaded_ball(picture, ball.x(), ball.y(), ball.z(), red_paint);
  add_noise(picture, 2, 4);
  const std::vector<Outline> seeds = circle_seeds(lab_image(picture), 4.5);
  ASSERT_GE(seeds.size(), 10u);
  for (const Eigen::Vector3d& ball : balls) {
    EXPECT_TRUE(std::any_of(seeds.begin(), seeds.begin() + 10, [&](const Outline& seed) {
      return (seed.center_px - ball.head<2>()).norm() < 0.25 * ball.z() &&
             std::abs(seed.radius_px - ball.z()) < 0.3 * ball.z();
    })) << ball.z();
  }
}

// A wall of squares of 13 px, of hexagons, of blobs: no part of it is a ball.
TEST(RoundRegions, ThePartsOfAPatternAreNoBalls) {
  for (const int corners : {4, 6}) {
    cv::Mat large(480 * 4, 640 * 4, CV_8UC3, cv::Scalar(150, 150, 150)), picture;
    for (int y = 20; y < 470; y += 20) {
      for (int x = 20; x < 630; x += 20) {
        std::vector<cv::Point> outline;
        for (int i = 0; i < corners; ++i) {
          const double angle = 2 * CV_PI * (i + 0.5) / corners;
          outline.emplace_back(cvRound(4 * (x + 8 * std::cos(angle))),
                               cvRound(4 * (y + 8 * std::sin(angle))));
        }
        cv::fillPoly(large, std::vector{outline}, {40, 60, 180});
      }
    }
    cv::resize(large, picture, {640, 480}, 0, 0, cv::INTER_AREA);
    add_noise(picture, 2, 4);
    for (const RoundRegion& region : find_round_regions(picture).regions)
      EXPECT_LT(region.evidence.log_odds(), 0) << corners << " corners, " << region.center_px.transpose();
  }
}

}  // namespace
}  // namespace ballservo
