#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "perception/judgement/outline_support.hpp"

namespace ballservo {
namespace {

constexpr int width = 160, height = 120;
constexpr double focal_px = 400, radius_px = 30;

Camera camera() {
  CameraParameters parameters;
  parameters.size = {width, height};
  parameters.fx_px = parameters.fy_px = focal_px;
  parameters.cx_px = 0.5 * (width - 1);
  parameters.cy_px = 0.5 * (height - 1);
  return Camera(parameters);
}

// A disc of one red before another, all of one class; the class ends to the right of `last_u`.
OutlineSectors sectors_seen(const cv::Scalar& disc, const cv::Scalar& behind, int last_u = width) {
  cv::Mat bgr(height, width, CV_8UC3, behind);
  cv::circle(bgr, {width / 2, height / 2}, static_cast<int>(radius_px), disc, cv::FILLED);
  BitPicture pixels;
  pixels.resize({width, height});
  for (int v = 0; v < height; ++v) {
    pixels.fill(v, 0, width, false);
    pixels.fill(v, 0, last_u, true);
  }
  OutlineSectors sectors;
  sectors.count = 48;
  const TangentCone cone{Eigen::Vector3d(0, 0, 1), std::atan(radius_px / focal_px)};
  see_steps_in_own_color(bgr, {1, pixels, {0, 0}}, camera(), cone, sectors);
  return sectors;
}

TEST(OutlineSteps, ABallBeforeItsOwnColorIsSeenAllAround) {
  EXPECT_EQ(sectors_seen({30, 30, 200}, {30, 30, 180}).fraction(), 1);
}

TEST(OutlineSteps, WhereOneColorRunsOnThereIsNone) {
  EXPECT_EQ(sectors_seen({30, 30, 200}, {30, 30, 200}).fraction(), 0);
  EXPECT_EQ(sectors_seen({30, 30, 200}, {31, 29, 199}).fraction(), 0);  // nor in a little noise
}

TEST(OutlineSteps, AnotherColorOutsideIsTheBoundarysBusiness) {
  EXPECT_NEAR(sectors_seen({30, 30, 200}, {30, 30, 180}, width / 2).fraction(), 0.5, 0.05);
}

}  // namespace
}  // namespace ballservo
