// Small exact pictures for perception's tests: discs and balls painted by supersampling, without the
// simulator.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/base/random.hpp"
#include "calibration/camera/ray_table.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/detector.hpp"

namespace ballservo::test {

inline const cv::Vec3b red(40, 40, 210), green(60, 200, 50), grey(120, 120, 120);

/// Two classes, told by their strongest channel: red (1) and green (2).
inline std::shared_ptr<const ColorTable> red_and_green() {
  auto colors = std::make_shared<ColorTable>();
  for (const char* name : {"red", "green"}) {
    colors->classes.push_back({});
    colors->classes.back().name = name;
  }
  for (int r = 0; r < 64; ++r) {
    for (int g = 0; g < 64; ++g) {
      for (int b = 0; b < 64; ++b) {
        ClassIndex& entry = colors->table[static_cast<std::size_t>((r << 12) | (g << 6) | b)];
        if (r > 2 * g && r > 2 * b && r > 12) entry = 1;
        if (g > 2 * r && g > 2 * b && g > 12) entry = 2;
      }
    }
  }
  return colors;
}

inline Camera pinhole(ImageSize size, double focal_px) {
  CameraParameters parameters;
  parameters.size = size;
  parameters.fx_px = parameters.fy_px = focal_px;
  parameters.cx_px = 0.5 * (size.width_px - 1);
  parameters.cy_px = 0.5 * (size.height_px - 1);
  return Camera(parameters);
}

/// Paints what `inside(pixel)` covers, 8x8 samples a pixel, over the picture.
template <typename Inside>
void paint(cv::Mat& bgr, const cv::Vec3b& color, const Inside& inside) {
  constexpr int n = 8;
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      int covered = 0;
      for (int i = 0; i < n * n; ++i) {
        covered += inside(Eigen::Vector2d(u - 0.5 + (i % n + 0.5) / n, v - 0.5 + (i / n + 0.5) / n)) ? 1 : 0;
      }
      const double part = static_cast<double>(covered) / (n * n);
      cv::Vec3b& at = bgr.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) at[c] = cv::saturate_cast<std::uint8_t>(at[c] + part * (color[c] - at[c]));
    }
  }
}

inline void paint_disc(cv::Mat& bgr, const Eigen::Vector2d& center_px, double radius_px,
                       const cv::Vec3b& color) {
  const cv::Point corner(cvFloor(center_px.x() - radius_px), cvFloor(center_px.y() - radius_px));
  const int side = 2 * cvCeil(radius_px) + 2;
  const cv::Rect box = cv::Rect(corner, cv::Size(side, side)) & cv::Rect({0, 0}, bgr.size());
  cv::Mat around = bgr(box);
  const Eigen::Vector2d middle = center_px - Eigen::Vector2d(box.x, box.y);
  paint(around, color, [&](const Eigen::Vector2d& p) { return (p - middle).norm() <= radius_px; });
}

inline void add_noise(cv::Mat& bgr, double sigma, RandomEngine& engine) {
  cv::Mat noise(bgr.size(), CV_16SC3);
  cv::RNG(static_cast<std::uint64_t>(uniform(engine, 1, 1e9)))
      .fill(noise, cv::RNG::NORMAL, cv::Scalar::all(0), cv::Scalar::all(sigma));
  cv::add(bgr, noise, bgr, cv::noArray(), CV_8U);
}

/// A sphere in a far camera's eye, lit from the left above.
inline void paint_shaded_disc(cv::Mat& bgr, const Eigen::Vector2d& center_px, double radius_px,
                              const cv::Vec3b& color) {
  cv::Mat flat = bgr.clone();
  paint_disc(flat, center_px, radius_px, color);
  for (int v = 0; v < bgr.rows; ++v) {
    for (int u = 0; u < bgr.cols; ++u) {
      const Eigen::Vector2d n = (Eigen::Vector2d(u, v) - center_px) / radius_px;
      if (n.norm() > 1.1) continue;
      const double depth = std::sqrt(std::max(0.0, 1 - n.squaredNorm()));
      const double light =
          0.5 +
          0.5 * std::max(0.0, Eigen::Vector3d(n.x(), n.y(), depth).dot(Eigen::Vector3d(-0.5, -0.5, 0.7071)));
      const double inside = (flat.at<cv::Vec3b>(v, u)[2] - bgr.at<cv::Vec3b>(v, u)[2]) /
                            std::max(1.0, static_cast<double>(color[2] - bgr.at<cv::Vec3b>(v, u)[2]));
      for (int c = 0; c < 3; ++c) {
        std::uint8_t& level = bgr.at<cv::Vec3b>(v, u)[c];
        level = cv::saturate_cast<std::uint8_t>(level + inside * (light * color[c] - level));
      }
    }
  }
}

/// A flat ball, exactly where the camera sees it.
inline void paint_ball(cv::Mat& bgr, const Camera& camera, const Eigen::Vector3d& p_C, double radius_m,
                       const cv::Vec3b& color) {
  const double cosine = std::sqrt(1 - std::pow(radius_m / p_C.norm(), 2));
  paint(bgr, color, [&](const Eigen::Vector2d& p) {
    const auto ray = camera.unproject(p);
    return ray && ray->dot(p_C.normalized()) >= cosine;
  });
}

inline cv::Mat grey_picture(int width = 320, int height = 240) {
  return cv::Mat(height, width, CV_8UC3, grey);
}

inline Detector detector_for(const Camera& camera, double radius_m = 0, BallFit fit = BallFit::sphere) {
  DetectorOptions options;
  options.fit = fit;
  if (radius_m > 0) options.radii.assign(2, BallRadius{radius_m, 0});
  return Detector(std::make_shared<const RayTable>(camera), red_and_green(), options);
}

}  // namespace ballservo::test
