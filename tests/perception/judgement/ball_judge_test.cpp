#include "perception/judgement/ball_judge.hpp"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace ballservo
