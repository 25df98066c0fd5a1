#include "perception/outline/picture_noise.hpp"

#include <gtest/gtest.h>

#include <random>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

/// A slope of light from left to right, half of it with stripes where it is textured, and noise.
cv::Mat slope(double sigma, bool textured = false) {
  RandomEngine engine = random_stream(1, "picture_noise_test");
  std::normal_distribution<double> normal;
  cv::Mat bgr(240, 320, CV_8UC3);
  bgr.forEach<cv::Vec3b>([&](cv::Vec3b& pixel, const int* at) {
    pixel = cv::Vec3b::all(
        static_cast<std::uint8_t>(60 + at[1] / 3 + (textured && at[0] > 120 ? at[1] % 4 * 12 : 0)));
  });
  for (cv::Vec3b& pixel : cv::Mat3b(bgr)) {
    for (int c = 0; c < 3; ++c) pixel[c] = cv::saturate_cast<std::uint8_t>(pixel[c] + sigma * normal(engine));
  }
  return bgr;
}

TEST(PictureNoise, IsTheSigmaOfIndependentPixelsWhateverTheSlope) {
  for (const double sigma : {2., 5., 10.})
    EXPECT_NEAR(noise_sigma(slope(sigma)), sigma, 0.12 * sigma) << sigma;
}

TEST(PictureNoise, IsHardlyMoreWhereHalfThePictureIsTextured) {
  EXPECT_NEAR(noise_sigma(slope(3, true)), 3, 2.2);
  EXPECT_LT(noise_sigma(slope(0, true)), 0.5);
}

TEST(PictureNoise, IsNoneWhereNothingShows) {
  EXPECT_LT(noise_sigma(slope(0)), 0.5);
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 2), cv::Size(1, 100), cv::Size(100, 2)})
    EXPECT_EQ(noise_sigma(cv::Mat(size, CV_8UC3, cv::Scalar::all(80))), 0) << size;
}

}  // namespace
}  // namespace ballservo
