#include "perception/outline/noise_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "calibration/base/random.hpp"
#include "perception/outline/camera_response.hpp"

namespace ballservo {
namespace {

enum class Noise { of_a_sensor, the_same_everywhere, none };

/// A ramp of light from left to right (with waves upon half of it where it is textured), as a sensor
/// sees it and a camera shows it.
cv::Mat ramp(bool srgb, Noise noise, bool textured = false, cv::Size size = {320, 240}) {
  RandomEngine engine = random_stream(1, "noise_response_test");
  std::normal_distribution<double> normal;
  cv::Mat bgr(size, CV_8UC3);
  for (int v = 0; v < size.height; ++v) {
    for (int u = 0; u < size.width; ++u) {
      for (int c = 0; c < 3; ++c) {
        double light = 0.02 + 0.9 * u / size.width;
        if (textured && 2 * v > size.height) light *= 1 + 0.1 * std::sin(1.5 * u) * std::sin(1.1 * v);
        if (noise == Noise::of_a_sensor) light += normal(engine) * std::sqrt(2e-6 + 4e-5 * light);
        double level = 255 * light;
        if (srgb) level = CameraResponse::srgb().shown(std::max(0.0, level)).level;
        if (noise == Noise::the_same_everywhere) level += normal(engine);
        bgr.at<cv::Vec3b>(v, u)[c] = cv::saturate_cast<std::uint8_t>(level);
      }
    }
  }
  return bgr;
}

TEST(NoiseResponse, TellsASensorsNoiseWhereGreyLevelsAreProportionalFromSrgb) {
  for (const bool textured : {false, true}) {
    EXPECT_GT(srgb_log_odds_by_noise(ramp(true, Noise::of_a_sensor, textured)), 7) << textured;
    EXPECT_LT(srgb_log_odds_by_noise(ramp(false, Noise::of_a_sensor, textured)), -7) << textured;
  }
}

TEST(NoiseResponse, SaysLittleOfNoiseThatIsTheSameEverywhere) {
  for (const bool srgb : {false, true})
    EXPECT_NEAR(srgb_log_odds_by_noise(ramp(srgb, Noise::the_same_everywhere)), 0, 2) << srgb;
}

TEST(NoiseResponse, SaysNothingWhereThereIsNone) {
  EXPECT_EQ(srgb_log_odds_by_noise(ramp(true, Noise::none)), 0);
  EXPECT_EQ(srgb_log_odds_by_noise(cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(128))), 0);
  EXPECT_EQ(srgb_log_odds_by_noise(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(0))), 0);
  // Hardly anything but texture.
  cv::Mat checks(240, 320, CV_8UC3);
  checks.forEach<cv::Vec3b>([](cv::Vec3b& pixel, const int* at) {
    pixel = cv::Vec3b::all(static_cast<std::uint8_t>((at[0] / 2 + at[1] / 2) % 2 == 0 ? 40 : at[1] / 2 + 60));
  });
  EXPECT_EQ(srgb_log_odds_by_noise(checks), 0);
}

}  // namespace
}  // namespace ballservo
