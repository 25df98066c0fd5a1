// Somebody's own camera: pinhole, 640 x 480, f = 480 px, and the picture it takes of a shaded red ball.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

constexpr double focal_px = 480, center_x_px = 319.5, center_y_px = 239.5;

/// `p_CB`: the ball's centre in the camera frame (m), before the camera. 4 x 4 rays a pixel.
inline cv::Mat draw_ball(const Eigen::Vector3d& p_CB, double radius_m) {
  const Eigen::Vector3d sun = Eigen::Vector3d(-0.4, -0.8, -0.45).normalized();
  const cv::Vec3d wall(150, 155, 150), red(45, 35, 200);
  cv::Mat picture(480, 640, CV_8UC3, wall);
  const double half_px = 2 * focal_px * radius_m / p_CB.z();
  const cv::Rect around(static_cast<int>(center_x_px + focal_px * p_CB.x() / p_CB.z() - half_px),
                        static_cast<int>(center_y_px + focal_px * p_CB.y() / p_CB.z() - half_px),
                        static_cast<int>(2 * half_px), static_cast<int>(2 * half_px));
  const cv::Rect box = around & cv::Rect(0, 0, picture.cols, picture.rows);
  for (int v = box.y; v < box.y + box.height; ++v) {
    for (int u = box.x; u < box.x + box.width; ++u) {
      double covered = 0, light = 0;
      for (int k = 0; k < 16; ++k) {
        const Eigen::Vector3d ray = Eigen::Vector3d((u + (k % 4 - 1.5) / 4 - center_x_px) / focal_px,
                                                    (v + (k / 4 - 1.5) / 4 - center_y_px) / focal_px, 1)
                                        .normalized();
        const double along_m = ray.dot(p_CB);
        const double depth2 = along_m * along_m - p_CB.squaredNorm() + radius_m * radius_m;
        if (depth2 < 0) continue;
        const Eigen::Vector3d normal = ((along_m - std::sqrt(depth2)) * ray - p_CB) / radius_m;
        covered += 1.0 / 16;
        light += (0.55 + 0.45 * std::max(0.0, normal.dot(sun))) / 16;
      }
      picture.at<cv::Vec3b>(v, u) = wall * (1 - covered) + red * light;
    }
  }
  return picture;
}
