#include "perception/outline/paper_refinement.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

std::vector<RingPixel> ring_of(const UndistortedCircle& circle, int count) {
  std::vector<RingPixel> ring;
  for (int i = 0; i < count; ++i) {
    const double angle = 6.283185307179586 * i / count;
    ring.push_back({circle.center_px + circle.radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)),
                    1.0 + i % 3, 0, 0});
  }
  return ring;
}

TEST(PaperStep, StaysAtTheTruthAndReturnsToIt) {
  const UndistortedCircle truth{{30, -12}, 25};
  const auto ring = ring_of(truth, 100);
  EXPECT_LT(one_gauss_newton_step(truth, ring)->step_px, 1e-9);
  const auto fit = one_gauss_newton_step({{30.5, -12.4}, 24.6}, ring);
  EXPECT_LT((fit->circle.center_px - truth.center_px).norm(), 0.01);
  EXPECT_NEAR(fit->circle.radius_px, 25, 0.02);
}

TEST(PaperStep, DegenerateSetsHaveNoFit) {
  EXPECT_FALSE(one_gauss_newton_step(UndistortedCircle{{0, 0}, 10}, std::vector<RingPixel>{}));
  EXPECT_FALSE(one_gauss_newton_step(UndistortedCircle{{0, 0}, 10},
                                     std::vector<RingPixel>(9, RingPixel{{10, 0}, 1, 0, 0})));
  EXPECT_FALSE(one_gauss_newton_step(UndistortedCircle{{0, 0}, 10},
                                     std::vector<RingPixel>(9, RingPixel{{10, 0}, 0, 0, 0})));
}

TEST(RingPixels, LieOnTheEdgeOfADisc) {
  cv::Mat bgr = test::grey_picture();
  test::paint_disc(bgr, {150.2, 110.7}, 30, test::red);
  const RayTable rays(test::pinhole({320, 240}, 400));
  const UndistortedCircle circle{{150.2 - 159.5, 110.7 - 119.5}, 30};
  std::vector<RingPixel> ring;
  select_ring_pixels(bgr, rays, circle, ring);
  ASSERT_GT(ring.size(), 150u);
  for (const RingPixel& pixel : ring) EXPECT_NEAR((pixel.position_px - circle.center_px).norm(), 30, 1.6);
}

TEST(RingPixels, OutsideThePictureThereAreNone) {
  const RayTable rays(test::pinhole({320, 240}, 400));
  std::vector<RingPixel> ring;
  select_ring_pixels(test::grey_picture(), rays, {{5000, 0}, 30}, ring);
  EXPECT_TRUE(ring.empty());
}

TEST(PaperPosition, JacobianIsItsDerivative) {
  const UndistortedCircle circle{{120, -60}, 32};
  const Eigen::Matrix3d jacobian = paper_position_jacobian(circle, 500, 0.035);
  for (int i = 0; i < 3; ++i) {
    UndistortedCircle low = circle, high = circle;
    const double h = 1e-4;
    (i < 2 ? low.center_px(i) : low.radius_px) -= h;
    (i < 2 ? high.center_px(i) : high.radius_px) += h;
    const Eigen::Vector3d slope =
        (paper_position(high, 500, 0.035) - paper_position(low, 500, 0.035)) / (2 * h);
    EXPECT_LT((slope - jacobian.col(i)).norm(), 1e-8);
  }
}

TEST(PaperPosition, OnTheAxisItIsTheSpheresOwn) {
  // tan(alpha) = c_r / f for a ball on the axis.
  const double alpha = std::asin(0.035 / 1.2);
  EXPECT_NEAR(paper_position({{0, 0}, 500 * std::tan(alpha)}, 500, 0.035).z(), 1.2, 1e-12);
}

}  // namespace
}  // namespace ballservo
