#include "perception/judgement/second_look.hpp"

#include <gtest/gtest.h>

#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

constexpr double radius_px = 26;
const Eigen::Vector2d center_px(161.3, 118.6);

/// At a disc's own outline, all of which has its class.
SecondLook::Look look(const cv::Mat& bgr, double known_noise) {
  BitPicture everywhere;
  everywhere.resize(bgr.size());
  for (int v = 0; v < bgr.rows; ++v) everywhere.fill(v, 0, bgr.cols, true);
  SecondLook second_look;
  second_look.set_noise(known_noise);
  OutlineEllipse outline;
  outline.center_px = center_px;
  outline.radius_px = radius_px;
  return second_look.look(bgr, {1, everywhere, {0, 0}}, outline);
}

cv::Mat pale_ball() {
  cv::Mat bgr = test::grey_picture();
  test::paint_shaded_disc(bgr, center_px, radius_px, {100, 125, 140});
  cv::GaussianBlur(bgr, bgr, {}, 2);
  return bgr;
}

TEST(SecondLook, SeesAPaleBallInNoiseThatItKnows) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    RandomEngine engine = random_stream(seed, "second_look_test");
    cv::Mat bgr = pale_ball();
    test::add_noise(bgr, 10, engine);
    EXPECT_GT(look(bgr, 10).log_odds, look(bgr, 0).log_odds + 5) << seed;
    EXPECT_GT(look(bgr, 10).log_odds, 5) << seed;
  }
}

TEST(SecondLook, SeesTheSameCircleInBlocksOfPixels) {
  for (const double known_noise : {0., 4., 6., 20.}) {
    const SecondLook::Look found = look(pale_ball(), known_noise);
    EXPECT_LT((found.seen.center_px - center_px).norm(), 0.3) << known_noise;
    EXPECT_NEAR(found.seen.radius_px, radius_px, 0.5) << known_noise;
    EXPECT_GT(found.log_odds, 15) << known_noise;
  }
}

}  // namespace
}  // namespace ballservo
