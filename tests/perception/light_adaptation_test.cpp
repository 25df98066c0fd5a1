#include "perception/light_adaptation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/files/fault.hpp"
#include "calibration/files/random.hpp"
#include "perception/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

constexpr double dt_s = 1.0 / 30;
constexpr double radius_px = 14;
const Eigen::Vector2d middle(100, 60), aside(40, 80);

/// Reflectances, as the taught light shows them (blue, green, red).
const cv::Vec3b orange(20, 60, 190), wall(120, 125, 130), dark_wall(60, 50, 40);

/// Orange by hue and saturation alone: what no light but the taught one keeps.
std::shared_ptr<const ColorTable> orange_table() {
  auto colors = std::make_shared<ColorTable>();
  colors->classes.push_back({});
  colors->classes.back().name = "orange";
  for (int r = 0; r < 64; ++r) {
    for (int g = 0; g < 64; ++g) {
      for (int b = 0; b < 64; ++b) {
        const double green = (g + 0.5) / (r + 0.5), blue = (b + 0.5) / (r + 0.5);
        if (r >= 8 && green > 0.2 && green < 0.45 && blue < 0.22)
          colors->table[static_cast<std::size_t>((r << 12) | (g << 6) | b)] = 1;
      }
    }
  }
  return colors;
}

Tracker make_tracker(bool fixed_colors = false) {
  TrackerOptions options;
  options.fixed_colors = fixed_colors;
  return Tracker(
      Detector(std::make_shared<const RayTable>(test::pinhole({200, 120}, 300)), orange_table(), {}),
      options);
}

struct Disc {
  Eigen::Vector2d center_px;
  cv::Vec3b color;
};

/// A room of two walls with discs in it, under a light, with the noise of picture `index`.
cv::Mat picture(const std::vector<Disc>& discs, const LogGain& light, int index) {
  cv::Mat bgr(120, 200, CV_8UC3, wall);
  bgr.colRange(140, 200) = dark_wall;
  for (const Disc& disc : discs) test::paint_disc(bgr, disc.center_px, radius_px, disc.color);
  RandomEngine engine = random_stream(5, "light_test", static_cast<std::uint64_t>(index));
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      cv::Vec3b& pixel = bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) {
        const double noise = uniform(engine, -3, 3);
        pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] * std::exp(light[c]) + noise);
      }
    }
  }
  return bgr;
}

/// Warmer (above 0) or colder light, and darker or brighter.
LogGain light_of(double warmer, double level) {
  return LogGain(-1.25, 0.25, 1.0) * warmer + LogGain::Constant(level);
}

bool claims(const std::vector<Track>& tracks, const Eigen::Vector2d& center_px) {
  for (const Track& track : tracks) {
    if (track.state == Track::State::confirmed &&
        (track.ball.outline.center_px - center_px).norm() < 0.3 * radius_px)
      return true;
  }
  return false;
}

TEST(LightBounds, GiveTheNearestLightWithinThem) {
  const LightBounds bounds;
  const LogGain within(-0.4, 0.1, 0.5);
  EXPECT_LT((bounds.confine(within) - within).abs().maxCoeff(), 1e-12);
  EXPECT_LT((bounds.confine(LogGain::Constant(9)) - bounds.level).abs().maxCoeff(), 1e-12);
  const LogGain green(0, 3, 0);
  EXPECT_LT(bounds.confine(green).maxCoeff() - bounds.confine(green).minCoeff(), 0.5);
}

TEST(MiddleColor, ChangesByTheFactorOfTheLight) {
  const LogGain light = light_of(0.3, -0.4);
  const OutlineEllipse outline{middle, radius_px};
  const SurfaceColor before = middle_color(picture({{middle, orange}}, LogGain::Zero(), 0), outline);
  const SurfaceColor after = middle_color(picture({{middle, orange}}, light, 1), outline);
  EXPECT_LT((after.log_bgr - before.log_bgr - light).abs().maxCoeff(), 0.03);
  // Nothing is said of a place outside the picture.
  EXPECT_FALSE(middle_color(cv::Mat(120, 200, CV_8UC3, wall), {{-10, 60}, radius_px}).known[0]);
}

TEST(PictureSamples, TellTheLightFromThings) {
  PictureSamples before, other_things, other_light;
  before.take(picture({}, LogGain::Zero(), 0));
  other_things.take(picture({{middle, orange}, {aside, {30, 200, 30}}}, LogGain::Zero(), 1));
  const LogGain light = light_of(0.3, -0.4);
  other_light.take(picture({{middle, orange}}, light, 2));
  EXPECT_LT(other_things.change_since(before).log_bgr.abs().maxCoeff(), 0.02);
  EXPECT_LT((other_light.change_since(before).log_bgr - light).abs().maxCoeff(), 0.03);
}

TEST(LightAdaptation, FollowsASlowChangeThatLosesTheFixedColours) {
  Tracker adapting = make_tracker(), fixed = make_tracker(true);
  int kept = 0, kept_fixed = 0;
  constexpr int pictures = 300;
  for (int k = 0; k < pictures; ++k) {
    const LogGain light = light_of(-0.5 * k / pictures, -0.9 * k / pictures);
    const cv::Mat bgr = picture({{middle, orange}}, light, k);
    kept += claims(adapting.update(bgr, k * dt_s), middle);
    kept_fixed += claims(fixed.update(bgr, k * dt_s), middle);
  }
  EXPECT_EQ(kept, pictures - 2);
  EXPECT_LT(kept_fixed, pictures / 2);
  EXPECT_LT((adapting.light() - light_of(-0.5, -0.9)).abs().maxCoeff(), 0.05);
}

TEST(LightAdaptation, FollowsAJump) {
  for (const LogGain& jump : {light_of(-0.5, -0.5), light_of(0.4, -0.4), light_of(-0.35, 0.2)}) {
    Tracker tracker = make_tracker();
    for (int k = 0; k < 40; ++k) {
      const LogGain light = k < 20 ? LogGain::Zero() : jump;
      const auto& tracks = tracker.update(picture({{middle, orange}}, light, k), k * dt_s);
      EXPECT_EQ(claims(tracks, middle), k >= 2) << k << ", " << jump.transpose();
    }
    EXPECT_LT((tracker.light() - jump).abs().maxCoeff(), 0.06);
  }
}

// Looked at for a minute, nothing of a near colour becomes a ball, or moves what is believed of the light.
TEST(LightAdaptation, AFalseBallDoesNotBecomeOneByBeingLookedAt) {
  for (const cv::Vec3b& near_color : {cv::Vec3b(20, 95, 190), cv::Vec3b(20, 80, 190), cv::Vec3b(45, 55, 190),
                                      cv::Vec3b(20, 34, 190), cv::Vec3b(36, 60, 190)}) {
    Tracker tracker = make_tracker();
    int k = 0;
    for (; k < 30; ++k)
      tracker.update(picture({{middle, orange}, {aside, near_color}}, {0, 0, 0}, k), k * dt_s);
    const bool was_a_ball = claims(
        tracker.update(picture({{middle, orange}, {aside, near_color}}, {0, 0, 0}, k), k * dt_s), aside);
    const std::vector<cv::Mat> without{picture({{aside, near_color}}, {0, 0, 0}, 1000),
                                       picture({{aside, near_color}}, {0, 0, 0}, 1001),
                                       picture({{aside, near_color}}, {0, 0, 0}, 1002)};
    bool became_a_ball = false;
    for (; k < 30 + 1800; ++k)
      became_a_ball |= claims(tracker.update(without[static_cast<std::size_t>(k) % 3], k * dt_s), aside);
    EXPECT_EQ(became_a_ball, was_a_ball) << near_color;
    EXPECT_LT(tracker.light().abs().maxCoeff(), 0.05) << near_color;
    bool back = false;
    for (int last = k + 10; k < last; ++k)
      back = claims(tracker.update(picture({{middle, orange}, {aside, near_color}}, {0, 0, 0}, k), k * dt_s),
                    middle);
    EXPECT_TRUE(back) << near_color;
  }
}

// It takes the ball's place from one picture to the next, and then the light itself changes.
TEST(LightAdaptation, AThingInTheBallsPlaceTeachesNothing) {
  Tracker tracker = make_tracker();
  const cv::Vec3b yellower(20, 82, 190);
  int k = 0;
  for (; k < 60; ++k) tracker.update(picture({{middle, orange}}, {0, 0, 0}, k), k * dt_s);
  for (; k < 200; ++k) tracker.update(picture({{middle, yellower}}, {0, 0, 0}, k), k * dt_s);
  EXPECT_LT(tracker.light().abs().maxCoeff(), 0.05);
}

TEST(LightAdaptation, KeepsTheLightWhileNoBallIsThereAndFindsTheWayBack) {
  for (const bool light_returns : {false, true}) {
    Tracker tracker = make_tracker();
    const LogGain other = light_of(-0.5, -0.5);
    int k = 0;
    for (; k < 20; ++k) tracker.update(picture({{middle, orange}}, {0, 0, 0}, k), k * dt_s);
    for (; k < 60; ++k) tracker.update(picture({{middle, orange}}, other, k), k * dt_s);
    EXPECT_GT(tracker.light().abs().maxCoeff(), 0.5);
    const LogGain later = light_returns ? LogGain::Zero() : other;
    for (; k < 200; ++k) tracker.update(picture({}, later, k), k * dt_s);
    bool back = false;
    for (; k < 210; ++k) back = claims(tracker.update(picture({{aside, orange}}, later, k), k * dt_s), aside);
    EXPECT_TRUE(back) << light_returns;
    EXPECT_LT((tracker.light() - later).abs().maxCoeff(), 0.06) << light_returns;
  }
}

TEST(LightAdaptation, StaysWithinItsBoundsAndForgets) {
  LightAdaptationOptions options;
  options.forget_s = 10;
  LightAdaptation adaptation(orange_table(), options);
  BallObservation ball;
  ball.outline = {middle, radius_px};
  ball.quality = ball.support.fill = 1;
  BallLight memory;
  // A ball that turns green without end, slowly.
  for (int k = 0; k < 400; ++k) {
    const cv::Mat bgr(120, 200, CV_8UC3, cv::Scalar(20, 20 + 0.5 * k, 220 - 0.5 * k));
    adaptation.begin(bgr);
    adaptation.learn(bgr, ball, memory);
    adaptation.finish(k * dt_s);
  }
  EXPECT_LT((adaptation.gain() - options.bounds.confine(adaptation.gain())).abs().maxCoeff(), 1e-9);
  EXPECT_NE(adaptation.adapted()->table, adaptation.taught()->table);
  for (int k = 0; k < 20; ++k) {
    adaptation.begin(cv::Mat(120, 200, CV_8UC3, wall));
    adaptation.finish(30 + k * dt_s);
  }
  EXPECT_TRUE((adaptation.gain() == 0).all());
  EXPECT_EQ(adaptation.adapted()->table, adaptation.taught()->table);
}

TEST(LightAdaptation, RefusesOptionsWithoutSense) {
  LightAdaptationOptions options;
  options.follow_s = -1;
  options.min_quality = std::nan("");
  options.slices = 0;
  try {
    LightAdaptation(orange_table(), options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 3u);
  }
}

}  // namespace
}  // namespace ballservo
