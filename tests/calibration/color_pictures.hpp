// Drawn balls for the tests of colour calibration.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "calibration/base/random.hpp"

namespace ballservo::test {

/// A value of linear light, 0 to 1, as sRGB.
inline double srgb_from_linear(double v) {
  v = std::clamp(v, 0.0, 1.0);
  return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055);
}

/// A matt sphere of linear reflectance `bgr` under a light from the upper left, over what is there.
inline void draw_shaded_ball(cv::Mat& picture, double cx, double cy, double radius,
                             const Eigen::Vector3d& bgr, double ambient = 0.25) {
  const Eigen::Vector3d light = Eigen::Vector3d(-0.4, -0.5, 0.77).normalized();
  for (int y = std::max(0, static_cast<int>(cy - radius));
       y <= std::min<double>(picture.rows - 1, cy + radius); ++y) {
    for (int x = std::max(0, static_cast<int>(cx - radius));
         x <= std::min<double>(picture.cols - 1, cx + radius); ++x) {
      const double nx = (x - cx) / radius, ny = (y - cy) / radius, rest = 1 - nx * nx - ny * ny;
      if (rest < 0) continue;
      const double lambert = std::max(0.0, Eigen::Vector3d(nx, ny, std::sqrt(rest)).dot(light));
      const double strength = ambient + (1 - ambient) * lambert;
      for (int k = 0; k < 3; ++k) {
        picture.at<cv::Vec3b>(y, x)[k] = cv::saturate_cast<std::uint8_t>(srgb_from_linear(strength * bgr[k]));
      }
    }
  }
}

inline void add_noise(cv::Mat& picture, double sigma, std::uint64_t seed) {
  RandomEngine engine = random_stream(seed, "color_pictures");
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      for (int k = 0; k < 3; ++k) {
        std::uint8_t& value = picture.at<cv::Vec3b>(y, x)[k];
        value = cv::saturate_cast<std::uint8_t>(value + sigma * standard_normal(engine));
      }
    }
  }
}

// Linear reflectances, BGR.
inline const Eigen::Vector3d red_paint(0.03, 0.03, 0.65), green_paint(0.08, 0.45, 0.06),
    blue_paint(0.6, 0.15, 0.04), yellow_paint(0.03, 0.6, 0.7), grey_paint(0.3, 0.3, 0.3);

/// A grey picture, 320 x 240.
inline cv::Mat grey_picture() { return cv::Mat(240, 320, CV_8UC3, cv::Scalar(140, 140, 140)); }

}  // namespace ballservo::test
