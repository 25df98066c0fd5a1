// Following the light takes no memory from the heap: counted below operator new, where OpenCV allocates too.
#include <gtest/gtest.h>

#include "perception/tracking/light_adaptation.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/support/allocation_counter.hpp"

namespace ballservo {
namespace {

TEST(LightAllocation, FollowingTheLightTakesNoMemory) {
  cv::Mat bright = test::grey_picture(), dark;
  const OutlineEllipse outline{{160, 120}, 20};
  test::paint_disc(bright, outline.center_px, outline.radius_px, test::red);
  dark = bright * 0.6;
  BallObservation ball;
  ball.outline = outline;
  ball.quality = ball.support.fill = 1;
  BallLight memory;
  LightAdaptation adaptation;
  const long before = test::allocations();
  double time_s = 0;
  for (int k = 0; k < 60; ++k) {
    const cv::Mat& bgr = k % 20 < 10 ? bright : dark;  // sudden changes, told by the ball and by the picture
    adaptation.begin(bgr);
    if (k % 20 == 10) {
      EXPECT_TRUE(adaptation.assume_change());
      adaptation.settle_change(k % 40 == 10);
    }
    if (k % 7 != 3) adaptation.learn(bgr, ball, memory);
    adaptation.may_be_taught_light();
    adaptation.finish(time_s += 0.03);
  }
  adaptation.assume({});
  EXPECT_EQ(test::allocations() - before, 0);
}

TEST(LightAllocation, TheCounterCounts) {
  const long before = test::allocations();
  const auto colors = test::red_and_green();
  EXPECT_GT(test::allocations() - before, 0);
}

}  // namespace
}  // namespace ballservo
