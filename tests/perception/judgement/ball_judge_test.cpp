#include "perception/judgement/ball_judge.hpp"

#include <gtest/gtest.h>

#include "perception/judgement/occluding_edge.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

// Where a ball is expected, what hides it has an edge too, which may lie on its outline.
TEST(BallJudge, AnEdgeThatRunsStraightSufficesNowhere) {
  const cv::Mat bgr = test::grey_picture();
  BitPicture pixels;
  pixels.resize(bgr.size());
  const ColoredPixels colored{1, pixels, {0, 0}};
  const RayTable rays(test::pinhole({320, 240}, 500));
  const ClassView view{bgr, colored, CameraResponse::srgb(), {0.17}};
  const BallJudge judge(view, rays);
  OutlineFit fit;
  fit.ball.outline.radius_px = 30;
  fit.offsets.count = fit.edges.segments_in_picture = 24;
  OutlineSupport support;
  support.arc = support.fill = 0.6;
  EXPECT_TRUE(judge.suffices_where_expected(fit, support));
  support.shape.straight = 0.98;
  EXPECT_FALSE(judge.suffices_where_expected(fit, support));
}

// A quality is a part of what shows of a ball: of nothing there is none.
TEST(BallJudge, WhatShowsNothingOfItsRimIsNoHalfHiddenBall) {
  cv::Mat bgr = test::grey_picture();
  const Eigen::Vector2d center_px(160, 120);
  constexpr double radius_px = 30, focal_px = 500;
  bgr.colRange(190, 320) = test::green;  // behind which it could be
  BitPicture middle;                     // of the classes of the rim's pixels nothing is known
  middle.resize({36, 36});
  for (int v = 0; v < 36; ++v) middle.fill(v, 0, 36, true);
  const ColoredPixels colored{1, middle, {142, 102}};
  ASSERT_TRUE(is_behind_straight_edge(bgr, colored, {center_px, radius_px}));
  const RayTable rays(test::pinhole({320, 240}, focal_px));
  const ClassView view{bgr, colored, CameraResponse::srgb(), {min_ball_quality}};
  OutlineFit fit;
  fit.ball.cone = {rays.camera().unproject(center_px)->normalized(), radius_px / focal_px};
  fit.ball.outline = {center_px, radius_px};
  fit.offsets = EdgeOffsets(24);
  const Verdict verdict = BallJudge(view, rays).of(fit, {});
  ASSERT_EQ(verdict.support.hidden, 1);
  EXPECT_LE(verdict.quality, 1);
}

}  // namespace
}  // namespace ballservo
