#include "perception/tracking/light_adaptation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

constexpr double dt_s = 1.0 / 30;
constexpr int radius_px = 14;
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
  bool is_flat = false;
};

/// A room of two walls with discs in it, under a light, with the noise of picture `index`.
cv::Mat picture(const std::vector<Disc>& discs, const LogGain& light, int index) {
  cv::Mat bgr(120, 200, CV_8UC3, wall);
  bgr.colRange(140, 200) = dark_wall;
  for (const Disc& disc : discs) {
    const cv::Point corner(static_cast<int>(disc.center_px.x() - radius_px) - 2,
                           static_cast<int>(disc.center_px.y() - radius_px) - 2);
    cv::Mat around = bgr(cv::Rect(corner, cv::Size(2 * radius_px + 5, 2 * radius_px + 5)));
    const auto paint = disc.is_flat ? test::paint_disc : test::paint_shaded_disc;
    paint(around, disc.center_px - Eigen::Vector2d(corner.x, corner.y), radius_px, disc.color);
  }
  const LogGain factor = light.exp();
  RandomEngine engine = random_stream(5, "light_test", static_cast<std::uint64_t>(index));
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      cv::Vec3b& pixel = bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) {
        const double noise = uniform(engine, -3, 3);
        pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] * factor[c] + noise);
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
    if (track.state == TrackState::confirmed &&
        (track.ball.outline.center_px - center_px).norm() < 0.3 * radius_px)
      return true;
  }
  return false;
}

TEST(LightBounds, GiveTheNearestLightWithinThem) {
  const LogGain within = gain_of({0.3, -0.4, 0.02});
  EXPECT_LT((confined(within) - within).abs().maxCoeff(), 1e-12);
  EXPECT_LT((confined(LogGain::Constant(9)) - 2.1).abs().maxCoeff(), 1e-12);
  const LogGain green(0, 3, 0);
  EXPECT_LT(confined(green).maxCoeff() - confined(green).minCoeff(), 1);
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

/// In a dark picture much of what changes is noise: a share of it, summed over a minute, would be a light.
TEST(PictureSamples, NoiseIsNoChangeHoweverOften) {
  RandomEngine engine = random_stream(6, "light_test");
  cv::Mat noisy(120, 200, CV_8UC3);
  PictureSamples then, now;
  LogGain sum = LogGain::Zero();
  for (int i = 0; i <= 300; ++i) {
    for (auto pixel = noisy.begin<cv::Vec3b>(); pixel != noisy.end<cv::Vec3b>(); ++pixel) {
      for (int c = 0; c < 3; ++c)
        (*pixel)[c] = cv::saturate_cast<std::uint8_t>(45 + 5 * standard_normal(engine));
    }
    std::swap(then, now);
    now.take(noisy);
    if (i == 0) continue;
    const SurfaceColor change = now.change_since(then);
    ASSERT_TRUE(change.known.all());
    sum += change.log_bgr;
  }
  EXPECT_LT(sum.abs().maxCoeff(), 0.05);
}

TEST(LightAdaptation, FollowsASlowChangeThatLosesTheFixedColours) {
  Tracker adapting = make_tracker(), fixed = make_tracker(true);
  int kept = 0, kept_fixed = 0;
  constexpr int pictures = 300;
  for (int k = 0; k < pictures; ++k) {
    const LogGain light = light_of(-0.6 * k / pictures, -0.9 * k / pictures);
    const cv::Mat bgr = picture({{middle, orange}}, light, k);
    kept += claims(adapting.update(bgr, k * dt_s), middle);
    kept_fixed += claims(fixed.update(bgr, k * dt_s), middle);
  }
  EXPECT_EQ(kept, pictures - 2);
  EXPECT_LT(kept_fixed, 3 * pictures / 4);
  EXPECT_LT((adapting.light() - light_of(-0.6, -0.9)).abs().maxCoeff(), 0.05);
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

// A minute of looking at something of a near colour: it is taken for the ball no more often than by fixed
// colours, it moves nothing, and the ball is known when it comes back.
TEST(LightAdaptation, AFalseBallDoesNotBecomeOneByBeingLookedAt) {
  constexpr int with_ball = 30, without_ball = 600;
  constexpr double slow_dt_s = 0.1;  // the rate of a slow camera: a minute in 600 pictures
  // On the class's border, where it is taken for the ball now and then, and just beyond.
  for (const cv::Vec3b& near_color :
       {cv::Vec3b(38, 58, 190), cv::Vec3b(20, 41, 190), cv::Vec3b(20, 84, 190)}) {
    const auto scene = [&](bool ball, int k) {
      std::vector<Disc> discs{{aside, near_color, true}};
      if (ball) discs.push_back({middle, orange});
      return picture(discs, LogGain::Zero(), k);
    };
    const std::vector<cv::Mat> alone{scene(false, 1000), scene(false, 1001), scene(false, 1002),
                                     scene(false, 1003)};
    Tracker adapting = make_tracker(), fixed = make_tracker(true);
    int false_claims = 0, false_claims_fixed = 0;
    bool back = false;
    for (int k = 0; k < with_ball + without_ball + 5; ++k) {
      const bool away = k >= with_ball && k < with_ball + without_ball;
      const cv::Mat bgr = away ? alone[static_cast<std::size_t>(k) % alone.size()] : scene(true, k);
      const auto& tracks = adapting.update(bgr, k * slow_dt_s);
      false_claims += claims(tracks, aside);
      false_claims_fixed += claims(fixed.update(bgr, k * slow_dt_s), aside);
      back = claims(tracks, middle);
    }
    EXPECT_LE(false_claims, false_claims_fixed + without_ball / 100) << near_color;
    // Far less than what the table would be patched for.
    EXPECT_LT(adapting.light().abs().maxCoeff(), 0.75 * significant_gain) << near_color;
    EXPECT_TRUE(back) << near_color;
  }
}

// It takes the ball's place from one picture to the next, and then the light itself changes.
TEST(LightAdaptation, AThingInTheBallsPlaceTeachesNothing) {
  Tracker tracker = make_tracker();
  const cv::Vec3b yellower(20, 80, 190);
  int k = 0;
  for (; k < 60; ++k) tracker.update(picture({{middle, orange}}, {0, 0, 0}, k), k * dt_s);
  const std::vector<cv::Mat> other{picture({{middle, yellower}}, {0, 0, 0}, 1000),
                                   picture({{middle, yellower}}, {0, 0, 0}, 1001),
                                   picture({{middle, yellower}}, {0, 0, 0}, 1002)};
  for (; k < 60 + 1800; ++k) tracker.update(other[static_cast<std::size_t>(k) % other.size()], k * dt_s);
  EXPECT_LT(tracker.light().abs().maxCoeff(), 0.05);
}

// It slides over the ball, slowly, and stays for a while.
TEST(LightAdaptation, AThingThatCoversTheBallTeachesNothing) {
  const cv::Vec3b yellower(20, 80, 190);
  for (const int way_pictures : {10, 40, 100}) {
    Tracker tracker = make_tracker();
    const int stays = way_pictures == 40 ? 900 : 60;  // pictures
    for (int k = 0; k < 30 + way_pictures + stays; ++k) {
      const double share = std::clamp((k - 30.0) / way_pictures, 0.0, 1.0);
      const Eigen::Vector2d cover = middle + (1 - share) * Eigen::Vector2d(0, 2.2 * radius_px);
      tracker.update(picture({{middle, orange}, {cover, yellower}}, {0, 0, 0}, k), k * dt_s);
      EXPECT_LT(tracker.light().abs().maxCoeff(), 0.12) << k;
    }
    EXPECT_LT(tracker.light().abs().maxCoeff(), 0.1) << way_pictures;
  }
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
  LightAdaptation adaptation;
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
  EXPECT_LT((adaptation.gain() - confined(adaptation.gain())).abs().maxCoeff(), 1e-9);
  EXPECT_NE(adaptation.cells(), LightCells::as_taught());
  for (int k = 0; k < 20; ++k) {
    adaptation.begin(cv::Mat(120, 200, CV_8UC3, wall));
    adaptation.finish(320 + k * dt_s);
  }
  EXPECT_TRUE((adaptation.gain() == 0).all());
  EXPECT_EQ(adaptation.cells(), LightCells::as_taught());
}

}  // namespace
}  // namespace ballservo
