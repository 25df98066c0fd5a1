// The recipes that users would otherwise take, at their best: told what a user could tell them.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo::bench {

/// OpenCV's HoughCircles (HOUGH_GRADIENT) on the grey picture, told the radius to within a half.
class HoughGradient {
 public:
  explicit HoughGradient(double expected_radius_px) : radius_px_(expected_radius_px) {}
  std::vector<OutlineEllipse> find(const cv::Mat& bgr);

 private:
  double radius_px_;
  cv::Mat grey_;
  std::vector<cv::Vec3f> circles_;
};

/// The recipe of countless tutorials: range in HSV, opening and closing, contours, smallest enclosing circle.
class HsvContour {
 public:
  /// `hue` of the balls as OpenCV counts it, 0 to 180; 10 to each side count.
  explicit HsvContour(int hue) : hue_(hue) {}
  std::vector<OutlineEllipse> find(const cv::Mat& bgr);

 private:
  int hue_;
  cv::Mat hsv_, mask_, other_;
  std::vector<std::vector<cv::Point>> contours_;
};

}  // namespace ballservo::bench
