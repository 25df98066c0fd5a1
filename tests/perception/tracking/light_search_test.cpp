#include "perception/tracking/light_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/base/random.hpp"
#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

const Eigen::Vector2d center_px(130, 100);
constexpr double radius_px = 24;

/// A shaded ball before patches of grey, or of another hue, as the camera shows it: level = 255 (factor level
/// / 255)^power.
cv::Mat picture(const cv::Vec3b& ball, const LogGain& log_factor, double power = 1,
                const cv::Scalar& hue = cv::Scalar::all(1),
                decltype(test::paint_disc)* paint_ball = test::paint_shaded_disc) {
  cv::Mat bgr = test::grey_picture();
  RandomEngine engine = random_stream(3, "light_search_test");
  for (int v = 0; v < bgr.rows; v += 20)
    for (int u = 0; u < bgr.cols; u += 20) bgr(cv::Rect(u, v, 20, 20)) = hue * uniform(engine, 50, 200);
  paint_ball(bgr, center_px, radius_px, ball);
  const LogGain factor = log_factor.exp();
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& level = bgr.at<cv::Vec3b>(v, u)[c];
        level = cv::saturate_cast<std::uint8_t>(255 * std::pow(factor[c] * level / 255, power) +
                                                uniform(engine, -2, 2));
      }
    }
  }
  return bgr;
}

Detector make_detector() {
  return {std::make_shared<const RayTable>(test::pinhole({320, 240}, 400)), test::red_and_green(), {}};
}

/// A red that was learnt from a ball before greys, in bright light.
Detector taught_detector(const cv::Vec3b& red) {
  auto colors = std::make_shared<ColorTable>(*test::red_and_green());
  const auto cell = [](const cv::Vec3d& bgr) {
    const auto channel = [&](int c) { return static_cast<std::uint32_t>(bgr[c] / 4); };
    return CellCount{channel(2) << 12 | channel(1) << 6 | channel(0), 100};
  };
  for (double light = 0.5; light < 1; light += 0.05)
    colors->classes[0].cells.push_back(cell(light * cv::Vec3d(red)));
  for (std::size_t i = 0; i < colors->table.size(); ++i)
    if (i >> 12 <= 24) colors->table[i] = no_class;
  for (double grey = 50; grey < 200; grey += 4) colors->background.push_back(cell(cv::Vec3d::all(grey)));
  return {std::make_shared<const RayTable>(test::pinhole({320, 240}, 400)), colors, {}};
}

/// What the detector shows under the light that is found.
std::vector<BallObservation> balls_in(const cv::Mat& bgr, Detector detector = make_detector()) {
  EXPECT_TRUE(detector.detect(bgr).empty()) << "the taught light shows it";
  const auto found = LightSearch(detector).find(bgr);
  if (!found) return {};
  detector.set_light(cells_in(found->light));
  return detector.detect(bgr);
}

void expect_the_ball(const std::vector<BallObservation>& balls) {
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_NEAR((balls[0].outline.center_px - center_px).norm(), 0, 0.3);
  EXPECT_NEAR(balls[0].outline.radius_px, radius_px, 0.3);
}

TEST(LightSearch, FindsABallThatALampHides) {
  expect_the_ball(balls_in(picture(test::red, gain_of({-0.3, 0.9, 0}))));
}

TEST(LightSearch, FindsABallThatTheDarkHides) {
  expect_the_ball(balls_in(picture(test::red, LogGain::Constant(std::log(0.2)))));
}

TEST(LightSearch, ABallBeforeThingsOfOneHueIsInNoLightOfThatHue) {
  const cv::Scalar blue_wall(1, 0.5, 0.3), green_wall(0.7, 1, 0.5);
  // Of deep red only one channel says something in the dark.
  for (const cv::Vec3b& red : {test::red, cv::Vec3b(100, 100, 220)})
    for (const cv::Scalar& hue : {blue_wall, green_wall}) {
      const cv::Mat bgr = picture(red, LogGain::Constant(std::log(0.4)), 1, hue);
      expect_the_ball(balls_in(bgr, taught_detector(red)));
    }
}

TEST(LightSearch, WhatNoLightMakesSureAllTogetherMay) {
  const LogGain lamp = gain_of({-0.3, 0.9, 0});
  const cv::Mat bgr = picture(test::red, lamp, 1, cv::Scalar::all(1), test::paint_disc);
  EXPECT_EQ(balls_in(bgr).size(), 1u);
  LightSearch one_by_one(make_detector());
  one_by_one.begin();
  EXPECT_FALSE(one_by_one.go_on(bgr, LightSearch::all_lights));
}

TEST(LightSearch, NoLampTurnsOneColorIntoAnother) {
  const cv::Vec3b blue(200, 70, 40), white(200, 200, 200);
  for (const cv::Vec3b& other : {blue, white}) EXPECT_TRUE(balls_in(picture(other, {0, 0, 0})).empty());
}

TEST(LightSearch, NoLampTakesTheGreenAndBlueOfBrownAndLeavesItsRed) {
  const cv::Vec3b brown(60, 95, 150);
  auto colors = std::make_shared<ColorTable>(*test::red_and_green());
  for (std::size_t i = 0; i < colors->table.size(); ++i) {
    const cv::Vec3d cell(4.0 * (i & 63), 4.0 * (i >> 6 & 63), 4.0 * (i >> 12));
    const cv::Vec3d off = cell - cell.dot(brown) / cv::Vec3d(brown).dot(brown) * cv::Vec3d(brown);
    colors->table[i] = cell[2] > 50 && cv::norm(off) < 0.35 * cv::norm(cell) ? 1 : no_class;
    if (colors->table[i] == 1) colors->classes[0].cells.push_back({static_cast<std::uint32_t>(i), 1});
  }
  const Detector detector(std::make_shared<const RayTable>(test::pinhole({320, 240}, 400)), colors, {});
  expect_the_ball(balls_in(picture(brown, gain_of({-0.3, 0.9, 0})), detector));
  EXPECT_TRUE(balls_in(picture({14, 14, 220}, {0, 0, 0}), detector).empty());
}

TEST(LightSearch, WithoutABallThereIsNoLight) {
  cv::Mat bgr = picture(test::red, gain_of({0, 0.8, 0}));
  bgr.colRange(200, 280).copyTo(bgr.colRange(90, 170));
  EXPECT_TRUE(balls_in(bgr).empty());
}

TEST(LightSearch, ATrackBeginsInAnotherLightAndFollowsItFromThere) {
  Tracker tracker(make_detector());
  const LogGain lamp = gain_of({-0.3, 0.9, 0});
  for (int k = 0; k < 60; ++k) {
    tracker.update(picture(test::red, lamp - 0.01 * k), k / 30.0);
    if (k < 4) continue;
    ASSERT_EQ(tracker.update({}, 0).size(), 1u) << k;
    EXPECT_EQ(tracker.update({}, 0)[0].state, TrackState::confirmed) << k;
  }
  ASSERT_TRUE(tracker.assumed_light());
  EXPECT_LT((tracker.assumed_light()->gain - lamp).abs().maxCoeff(), 0.3);
  EXPECT_LT((tracker.light() + 0.59).abs().maxCoeff(), 0.1);
}

TEST(LightSearch, BeginsWithTheTenthPictureWhereItIsPutOff) {
  TrackerOptions options;
  options.seek_light_at_once = false;
  Tracker tracker(make_detector(), options);
  const cv::Mat bgr = picture(test::red, gain_of({-0.3, 0.9, 0}));
  for (int k = 0; k < newcomers_every; ++k) EXPECT_TRUE(tracker.update(bgr, k / 30.0).empty()) << k;
  for (int k = newcomers_every; k < 60; ++k) tracker.update(bgr, k / 30.0);
  EXPECT_TRUE(tracker.assumed_light());
}

TEST(LightSearch, WhenItsBallIsGoneTheTaughtLightIsAskedAgain) {
  for (const int pictures : {2, 5}) {  // which is not believed, and is
    Tracker tracker(make_detector());
    for (int k = 0; k < pictures; ++k) tracker.update(picture(test::red, gain_of({-0.3, 0.9, 0})), k / 30.0);
    EXPECT_EQ(tracker.assumed_light().has_value(), pictures == 5);
    for (int k = pictures; k < 60; ++k) tracker.update(test::grey_picture(), k / 30.0);
    for (int k = 60; k < 66; ++k) tracker.update(picture(test::red, LogGain::Zero()), k / 30.0);
    EXPECT_EQ(tracker.update({}, 0).size(), 1u);
    EXPECT_FALSE(tracker.assumed_light());
  }
}

TEST(LightSearch, ABallMissedForAMomentIsSoughtInTheSameLight) {
  Tracker tracker(make_detector());
  const cv::Mat bgr = picture(test::red, gain_of({-0.3, 0.9, 0}));
  EXPECT_EQ(tracker.update(bgr, 0).size(), 1u);
  for (int k = 1; k < 4; ++k) EXPECT_TRUE(tracker.update(test::grey_picture(), k / 30.0).empty());
  for (int k = 4; k < 6; ++k) tracker.update(bgr, k / 30.0);  // the taught light and this one take turns
  EXPECT_EQ(tracker.update({}, 0).size(), 1u);
}

TEST(LightSearch, ABallThatComesIntoViewLateIsFoundInItsLight) {
  const LogGain dark = LogGain::Constant(std::log(0.2));
  const cv::Mat with_ball = picture(test::red, dark);
  cv::Mat without = with_ball.clone();
  without.colRange(200, 280).copyTo(without.colRange(90, 170));
  Tracker tracker(make_detector());
  for (int k = 0; k < 100; ++k) tracker.update(without, k / 30.0);
  int k = 100;
  while (k < 140 && !tracker.assumed_light()) tracker.update(with_ball, k++ / 30.0);
  EXPECT_LT(k, 125);
}

TEST(LightSearch, ABallInTheDarkIsAsMuchABall) {
  const auto log_odds = [](double factor) {
    Detector detector = make_detector();
    const LogGain gain = LogGain::Constant(std::log(factor));
    detector.set_light(cells_in({gain}));
    const cv::Mat bgr = picture(test::red, gain);
    BallObservation ball;
    ball.color_class = 1;
    ball.outline = {center_px, radius_px};
    return detector.log_odds(bgr, ball);
  };
  EXPECT_NEAR(log_odds(0.35), log_odds(1), 0.8);
}

TEST(LightCells, APowerTurnsLinearLevelsIntoSrgb) {
  const LightCells cells = cells_in({LogGain::Zero(), 1 / 2.2});
  for (const int level : {20, 60, 120, 220}) {
    const double srgb = 255 * std::pow(level / 255.0, 1 / 2.2);
    EXPECT_NEAR(4 * cells.taught_cell[1][static_cast<std::size_t>(level / 4)] + 2, srgb,
                4 + 0.5 * srgb * 4 / level);
  }
}

}  // namespace
}  // namespace ballservo
