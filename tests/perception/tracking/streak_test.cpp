// A ball that moved while the shutter was open, painted as the mean of the places that it passed.
#include "perception/tracking/streak.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/tracking/tracker.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/perception/tracking/moving_balls.hpp"

namespace ballservo {
namespace {

const ImageSize size{320, 240};
constexpr double dt_s = 1.0 / 30;

// Mixes the light of a disc that moves by `way` with the background's, grey levels proportional to it.
void paint_streak(cv::Mat& bgr, const Eigen::Vector2d& center, const Eigen::Vector2d& way, double radius_px) {
  constexpr int instants = 24, n = 3;
  const double reach_px = way.norm() / 2 + radius_px + 1;
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const Eigen::Vector2d offset = Eigen::Vector2d(u, v) - center;
      if (offset.norm() > reach_px) continue;
      int covered = 0;
      for (int i = 0; i < instants * n * n; ++i) {
        const Eigen::Vector2d within((i % n + 0.5) / n - 0.5, (i / n % n + 0.5) / n - 0.5);
        const double moved = (i / (n * n) + 0.5) / instants - 0.5;
        covered += (offset + within - moved * way).norm() < radius_px ? 1 : 0;
      }
      cv::Vec3b& at = bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c)
        at[c] =
            cv::saturate_cast<std::uint8_t>(at[c] + (test::red[c] - at[c]) * covered / (instants * n * n));
    }
  }
}

const Eigen::Vector3d ball_bgr(test::red[0], test::red[1], test::red[2]);

TEST(Streak, IsMeasuredAsDiscAndWay) {
  RandomEngine engine(1);
  for (const double length_px : {15.0, 40.0, 80.0}) {
    for (const double turn_rad : {0.0, 0.6, 1.9}) {
      const Eigen::Vector2d center(158.3, 121.6),
          way(length_px * std::cos(turn_rad), length_px * std::sin(turn_rad));
      cv::Mat bgr = test::grey_picture();
      paint_streak(bgr, center, way, 14);
      test::add_noise(bgr, 2, engine);
      // Expected a radius off, in a direction and with a length of its own.
      const Eigen::Vector2d off = 7 * Eigen::Vector2d(1, -1);
      const auto streak = measure_streak(bgr, CameraResponse::linear(), ball_bgr,
                                         {center + off, 1.2 * way + Eigen::Vector2d(3, 3), 15});
      ASSERT_TRUE(streak) << length_px << " " << turn_rad;
      EXPECT_LT((streak->center_px - center).norm(), 0.1 * 14 + 0.02 * length_px);
      EXPECT_NEAR(streak->half_width_px, 14, 1.4);
      EXPECT_NEAR(streak->way_px.norm(), length_px, 0.1 * length_px + 2);
      EXPECT_GT(streak->explained, 0.85);
    }
  }
}

TEST(Streak, WhatIsNoneIsRefused) {
  const Camera camera = test::pinhole(size, 400);
  const auto find = [&](const cv::Mat& bgr) {
    return find_streak(bgr, camera, CameraResponse::linear(), ball_bgr, {{160, 120}, {50, 0}, 14}, {});
  };
  cv::Mat streak = test::grey_picture();
  paint_streak(streak, {160, 120}, {40, 0}, 14);
  EXPECT_TRUE(find(streak));
  EXPECT_FALSE(find(test::grey_picture())) << "an empty place";
  cv::Mat across = test::grey_picture();
  paint_streak(across, {160, 120}, {0, 40}, 14);
  EXPECT_FALSE(find(across)) << "one that moves another way";
  cv::Mat bar = test::grey_picture();
  test::paint(bar, test::red, [](const Eigen::Vector2d& p) { return std::abs(p.y() - 120) < 14; });
  EXPECT_FALSE(find(bar)) << "a bar without ends";
  cv::Mat box = test::grey_picture();
  test::paint(box, test::red, [](const Eigen::Vector2d& p) {
    return std::abs(p.y() - 120) < 14 && std::abs(p.x() - 160) < 40;
  });
  EXPECT_FALSE(find(box)) << "a box, which covers all that it covers";
  cv::Mat blue = test::grey_picture();
  test::paint(blue, {200, 90, 60},
              [](const Eigen::Vector2d& p) { return (p - Eigen::Vector2d(160, 120)).norm() < 14; });
  EXPECT_FALSE(find(blue)) << "another colour";
  cv::Mat cut = test::grey_picture();
  paint_streak(cut, {160, 2}, {40, 0}, 14);
  EXPECT_FALSE(find_streak(cut, camera, CameraResponse::linear(), ball_bgr, {{160, 2}, {50, 0}, 14}, {}))
      << "cut by the border";
}

// A throw: the ball is followed where it is smeared, and its place stays within what its covariance says.
TEST(Streak, AThrownBallIsFollowedWhileItIsSmeared) {
  for (const bool fixed_colors : {false, true}) {
    TrackerOptions options;
    options.fixed_colors = fixed_colors;
    Tracker tracker(test::detector_for(test::pinhole(size, 400), 0.05), options);
    for (int k = 0; k < 13; ++k) {
      cv::Mat bgr = test::grey_picture();
      // From a stand, ever faster: up to 40 px a picture, three quarters of it with the shutter open.
      const double fallen = std::max(0, k - 5);
      const Eigen::Vector2d at(100 + 5 * fallen, 40 + 2.6 * fallen * fallen);
      paint_streak(bgr, at, 0.75 * Eigen::Vector2d(fallen > 0 ? 5 : 0, 5.2 * fallen), 14);
      const auto& tracks = tracker.update(bgr, k * dt_s);
      ASSERT_EQ(tracks.size(), 1u) << k;
      EXPECT_EQ(tracks[0].id, 1);
      EXPECT_EQ(tracks[0].state, k < 4 ? TrackState::tentative : TrackState::confirmed)
          << k << ", it is flat";
      EXPECT_LT((tracks[0].ball.outline.center_px - at).norm(), 0.25 * 14) << k;
    }
  }
}

}  // namespace
}  // namespace ballservo
