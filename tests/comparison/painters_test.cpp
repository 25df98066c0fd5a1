// Rooms and painted pictures: the truth that they come with is what they show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "app/comparison/pictures/plan.hpp"
#include "app/comparison/pictures/rendered_frame.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

struct Shown {
  Painter painter;
  const char* color;
};

class EveryPainter : public testing::TestWithParam<Shown> {
 protected:
  ComparisonCondition condition() const {
    ComparisonCondition it;
    it.name = "shown";
    it.painter = GetParam().painter;
    it.ball_color = GetParam().color;
    it.sensor.blur_px = 0.7;
    return it;
  }
  int own_channel_bgr() const {
    const std::string color = GetParam().color;
    return color == "red" ? 2 : color == "green" ? 1 : 0;
  }
  // The ball's own channel stands out at that place (px).
  bool is_ball_at(const cv::Mat& bgr, const Eigen::Vector2d& p) const {
    const cv::Vec3b pixel =
        bgr.at<cv::Vec3b>(static_cast<int>(std::lround(p.y())), static_cast<int>(std::lround(p.x())));
    const int own = own_channel_bgr();
    return pixel[own] > 1.9 * pixel[(own + 1) % 3] && pixel[own] > 1.9 * pixel[(own + 2) % 3];
  }
  // Part of a circle around the truth's centre, `part` of its radius large, that shows the ball.
  double share_of_ball(const RenderedFrame& frame, double part) const {
    int seen = 0;
    for (int k = 0; k < 64; ++k) {
      const double angle = 2 * M_PI * k / 64;
      seen += is_ball_at(
          frame.bgr, frame.truth.outline->center_px + part * frame.truth.outline->radius_px *
                                                          Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    return seen / 64.0;
  }
};

TEST_P(EveryPainter, ShowsTheBallWhereTheTruthSays) {
  for (int k = 0; k < 4; ++k) {
    const RenderedFrame frame = render_comparison_frame(condition(), 1, k);
    ASSERT_TRUE(frame.truth.outline);
    EXPECT_GT(share_of_ball(frame, 0.9), 0.85) << k;
    EXPECT_LT(share_of_ball(frame, 1.15), 0.1) << k;
    EXPECT_NEAR(frame.truth.p_CB.z(), 1, 0.021);
    EXPECT_LT(frame.truth.p_CB.head<2>().norm(), 0.21);
    EXPECT_FALSE(frame.clean_bgr.empty());
  }
}

TEST_P(EveryPainter, HidesTheWantedPart) {
  ComparisonCondition hidden = condition();
  hidden.occlusion = 0.5;
  for (int k = 0; k < 4; ++k) {
    const RenderedFrame frame = render_comparison_frame(hidden, 1, k);
    EXPECT_NEAR(frame.truth.visible_fraction, 0.5, 0.03);
    EXPECT_LT(share_of_ball(frame, 0.8), 0.75) << k;
    EXPECT_GT(share_of_ball(frame, 0.8), 0.25) << k;
  }
}

TEST_P(EveryPainter, PutsTheBallAtTheBorder) {
  ComparisonCondition cut = condition();
  cut.at_border = true;
  for (int k = 0; k < 4; ++k) {
    const RenderedFrame frame = render_comparison_frame(cut, 1, k);
    const Eigen::Vector2d p = frame.truth.outline->center_px;
    const double inside_px = std::min({p.x(), p.y(), 639 - p.x(), 479 - p.y()});
    EXPECT_LT(std::abs(inside_px), 0.15 * frame.truth.outline->radius_px) << k;
  }
}

TEST_P(EveryPainter, LeavesTheBallOut) {
  ComparisonCondition empty = condition();
  empty.has_ball = false;
  const RenderedFrame frame = render_comparison_frame(empty, 1, 0);
  EXPECT_FALSE(frame.truth.outline);
  EXPECT_TRUE(frame.clean_bgr.empty());
}

TEST_P(EveryPainter, IsTheSameForTheSameSeed) {
  const auto differs = [&](int a, int b) {
    return cv::norm(render_comparison_frame(condition(), 1, a).bgr,
                    render_comparison_frame(condition(), 1, b).bgr, cv::NORM_INF) > 0;
  };
  EXPECT_FALSE(differs(3, 3));
  EXPECT_TRUE(differs(3, 4));
}

INSTANTIATE_TEST_SUITE_P(Painters, EveryPainter,
                         testing::Values(Shown{Painter::room, "red"}, Shown{Painter::room, "blue"},
                                         Shown{Painter::painted, "green"}, Shown{Painter::painted, "red"}));

// What a picture would not show must not pass for a condition.
TEST(Painters, RefuseWhatTheyDoNotShow) {
  for (const char* keys :
       {"no_ball: true", "at_border: true", "pictures: {type: lab, marbled: true}",
        "pictures: {type: room, half_shade: true}", "pictures: {type: room}, ball: {color: yellow}",
        "pictures: {type: room}, contrast: 0.5", "pictures: {type: room}, motion_blur_px: 3",
        "pictures: {type: painted}, touching: true", "pictures: {type: painted}, noise: {shot: 1}",
        "pictures: {type: painted}, background: plain", "pictures: {type: chalk}"}) {
    EXPECT_THROW(parse_comparison_plan(std::string("conditions: [{name: a, ") + keys + "}]", "p.yaml", "."),
                 InputError)
        << keys;
  }
  EXPECT_NO_THROW(parse_comparison_plan(
      "conditions: [{name: a, pictures: {type: room}, no_ball: true, same_color: 4}]", "p.yaml", "."));
}

}  // namespace
}  // namespace ballservo
