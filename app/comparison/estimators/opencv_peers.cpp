#include "app/comparison/estimators/opencv_peers.hpp"

#include <algorithm>

namespace ballservo {
// Circles of half to one and a half times the radius, at least a radius apart.
std::vector<OutlineEllipse> HoughGradient::find(const cv::Mat& bgr) {
  cv::cvtColor(bgr, grey_, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey_, grey_, {5, 5}, 1.2);
  circles_.clear();  // HoughCircles leaves what it was given where it finds nothing
  cv::HoughCircles(grey_, circles_, settings_.mode, settings_.mode == cv::HOUGH_GRADIENT ? 1 : 1.5,
                   std::max(1.0, radius_px_), settings_.edges, settings_.support,
                   static_cast<int>(0.5 * radius_px_), static_cast<int>(1.5 * radius_px_));
  std::vector<OutlineEllipse> found;
  for (const cv::Vec3f& circle : circles_) found.push_back({{circle[0], circle[1]}, circle[2]});
  return found;
}

const cv::Mat& HsvContour::mask(const cv::Mat& bgr) {
  constexpr int reach = 10, turn = 180;
  const double s = settings_.least_saturation, v = settings_.least_value;
  cv::cvtColor(bgr, hsv_, cv::COLOR_BGR2HSV);
  cv::inRange(hsv_, cv::Scalar(std::max(0, hue_ - reach), s, v),
              cv::Scalar(std::min(turn, hue_ + reach), 255, 255), mask_);
  // A range across hue 0 is two ranges.
  if (hue_ < reach || hue_ > turn - reach) {
    const int low = hue_ < reach ? turn + hue_ - reach : 0, high = hue_ < reach ? turn : hue_ + reach - turn;
    cv::inRange(hsv_, cv::Scalar(low, s, v), cv::Scalar(high, 255, 255), other_);
    cv::bitwise_or(mask_, other_, mask_);
  }
  cv::morphologyEx(mask_, mask_, cv::MORPH_OPEN, cv::Mat());
  cv::morphologyEx(mask_, mask_, cv::MORPH_CLOSE, cv::Mat());
  return mask_;
}

std::vector<OutlineEllipse> HsvContour::find(const cv::Mat& bgr) {
  cv::findContours(mask(bgr), contours_, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
  std::vector<OutlineEllipse> found;
  for (const auto& contour : contours_) {
    cv::Point2f center;
    float radius = 0;
    cv::minEnclosingCircle(contour, center, radius);
    if (radius >= 3) found.push_back({{center.x, center.y}, radius});
  }
  std::stable_sort(found.begin(), found.end(), [](const OutlineEllipse& a, const OutlineEllipse& b) {
    return a.radius_px > b.radius_px;
  });
  return found;
}

}  // namespace ballservo
