// The recipes that users of OpenCV would otherwise take, told what a user could tell them.
#pragma once

#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

/// What users of HoughCircles turn.
struct HoughSettings {
  /// HOUGH_GRADIENT, or HOUGH_GRADIENT_ALT, which refines what it finds (4.3 and later).
  cv::HoughModes mode = cv::HOUGH_GRADIENT;
  double edges = 100;   ///< param1: the upper threshold of the edges
  double support = 20;  ///< param2: votes; of HOUGH_GRADIENT_ALT roundness, 0 to 1
};

/// HoughCircles on the grey picture, told the radius to within a half. The circle with the most votes first.
class HoughGradient {
 public:
  explicit HoughGradient(double expected_radius_px, const HoughSettings& settings = {})
      : radius_px_(expected_radius_px), settings_(settings) {}
  std::vector<OutlineEllipse> find(const cv::Mat& bgr);

 private:
  double radius_px_;
  HoughSettings settings_;
  cv::Mat grey_;
  std::vector<cv::Vec3f> circles_;
};

/// The range in HSV that counts as the ball's colour: 10 of OpenCV's 180 hues to each side.
struct HsvSettings {
  double least_saturation = 120, least_value = 30;
};

/// The recipe of countless tutorials: range in HSV, opening and closing, contours, smallest enclosing circle.
class HsvContour {
 public:
  /// `hue` of the balls as OpenCV counts it, 0 to 180.
  explicit HsvContour(int hue, const HsvSettings& settings = {}) : hue_(hue), settings_(settings) {}
  /// The largest first.
  std::vector<OutlineEllipse> find(const cv::Mat& bgr);
  /// The pixels whose hue and saturation are a ball's, opened and closed; until the next call.
  const cv::Mat& mask(const cv::Mat& bgr);

 private:
  int hue_;
  HsvSettings settings_;
  cv::Mat hsv_, mask_, other_;
  std::vector<std::vector<cv::Point>> contours_;
};

}  // namespace ballservo
