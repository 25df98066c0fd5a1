#include "servo/simulation/rendering/sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace ballservo {
namespace {

cv::Mat grey(double level, int side = 256) {
  return cv::Mat(side, side, CV_32FC3, cv::Scalar::all(level / 255.0));
}

TEST(Sensor, NoiseHasTheStatedVariance) {
  SensorOptions options;
  options.read_noise = 2.0;
  options.shot_noise = 0.3;
  for (const double level : {30.0, 120.0, 200.0}) {
    cv::Scalar mean, sigma;
    cv::meanStdDev(expose(grey(level), options, 5, 1), mean, sigma);
    const double expected = 4.0 + 0.3 * level + 1.0 / 12.0;  // and rounding to whole levels
    for (int channel = 0; channel < 3; ++channel) {
      EXPECT_NEAR(mean[channel], level, 0.1);
      EXPECT_NEAR(sigma[channel] * sigma[channel] / expected, 1.0, 0.03);
    }
  }
}

TEST(Sensor, NoiseOfNeighboursIsIndependent) {
  SensorOptions options;
  options.read_noise = 10;
  const cv::Mat picture = expose(grey(128), options, 1, 0);
  double along = 0, down = 0, channels = 0, variance = 0;
  for (int row = 0; row + 1 < picture.rows; ++row) {
    for (int column = 0; column + 1 < picture.cols; ++column) {
      const double here = picture.at<cv::Vec3b>(row, column)[0] - 128.0;
      variance += here * here;
      along += here * (picture.at<cv::Vec3b>(row, column + 1)[0] - 128.0);
      down += here * (picture.at<cv::Vec3b>(row + 1, column)[0] - 128.0);
      channels += here * (picture.at<cv::Vec3b>(row, column)[1] - 128.0);
    }
  }
  for (const double covariance : {along, down, channels}) EXPECT_LT(std::abs(covariance / variance), 0.02);
}

TEST(Sensor, BlurKeepsLightAndPlace) {
  cv::Mat light(41, 61, CV_32FC3, cv::Scalar::all(0));
  light.at<cv::Vec3f>(20, 30) = {1, 1, 1};
  SensorOptions options;
  options.blur_px = 1.5;
  options.gain = 15;  // the middle of the spot just below full scale
  const cv::Mat picture = expose(light, options, 0, 0);
  double sum = 0, x = 0, y = 0, square = 0;
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      const double value = picture.at<cv::Vec3b>(row, column)[2];
      sum += value;
      x += value * column;
      y += value * row;
      square += value * (column - 30) * (column - 30);
    }
  }
  EXPECT_NEAR(sum, 255 * 15, 60);
  EXPECT_NEAR(x / sum, 30, 1e-9);
  EXPECT_NEAR(y / sum, 20, 1e-9);
  EXPECT_NEAR(std::sqrt(square / sum), 1.5, 0.1);
}

TEST(Sensor, LinearLightIsRoundedAndCutOff) {
  EXPECT_EQ(expose(grey(100.4, 4), {}, 0, 0).at<cv::Vec3b>(1, 1)[0], 100);
  EXPECT_EQ(expose(grey(100.6, 4), {}, 0, 0).at<cv::Vec3b>(1, 1)[0], 101);
  EXPECT_EQ(expose(grey(700, 4), {}, 0, 0).at<cv::Vec3b>(1, 1)[0], 255);
}

TEST(Sensor, GammaLiftsTheMiddleAndKeepsTheEnds) {
  SensorOptions options;
  options.gamma = 2.2;
  EXPECT_EQ(expose(grey(0, 4), options, 0, 0).at<cv::Vec3b>(0, 0)[0], 0);
  EXPECT_EQ(expose(grey(255, 4), options, 0, 0).at<cv::Vec3b>(0, 0)[0], 255);
  EXPECT_NEAR(expose(grey(51, 4), options, 0, 0).at<cv::Vec3b>(0, 0)[0], 255 * std::pow(0.2, 1 / 2.2), 1);
}

}  // namespace
}  // namespace ballservo
