#include "app/report/overlay.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

namespace {

int fixed_point(double x) {
  return static_cast<int>(std::lround(std::clamp(x, -1e5, 1e5) * (1 << subpixel_bits)));
}

// None where one of them is not known.
std::vector<cv::Point> subpixels(const std::vector<Eigen::Vector2d>& points_px) {
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& p : points_px) {
    if (!p.allFinite()) return {};
    points.push_back(subpixel(p));
  }
  return points;
}

}  // namespace

cv::Point subpixel(const Eigen::Vector2d& p) { return {fixed_point(p.x()), fixed_point(p.y())}; }

cv::Scalar class_display_color(const ColorTable& colors, ClassIndex color_class) {
  cv::Scalar sum(0, 0, 0);
  double count = 0;
  for (int i = 0; i < ColorTable::entries; ++i) {
    if (colors.table[static_cast<std::size_t>(i)] != color_class) continue;
    sum += cv::Scalar((i & 63) * 4 + 2, ((i >> 6) & 63) * 4 + 2, (i >> 12) * 4 + 2);
    ++count;
  }
  return count > 0 ? sum / count : cv::Scalar(255, 255, 255);
}

void draw_polyline(cv::Mat& bgr, const std::vector<Eigen::Vector2d>& points_px, bool closed,
                   const cv::Scalar& color, int thickness) {
  const std::vector<cv::Point> points = subpixels(points_px);
  if (!points.empty()) cv::polylines(bgr, points, closed, color, thickness, cv::LINE_AA, subpixel_bits);
}

void fill_polygon(cv::Mat& bgr, const std::vector<Eigen::Vector2d>& points_px, const cv::Scalar& color) {
  cv::fillPoly(bgr, std::vector<std::vector<cv::Point>>{subpixels(points_px)}, color, cv::LINE_AA,
               subpixel_bits);
}

void draw_circle(cv::Mat& bgr, const Eigen::Vector2d& center_px, double radius_px, const cv::Scalar& color,
                 int thickness) {
  cv::circle(bgr, subpixel(center_px), fixed_point(radius_px), color, thickness, cv::LINE_AA, subpixel_bits);
}

void draw_cross(cv::Mat& bgr, const Eigen::Vector2d& center_px, const cv::Scalar& color) {
  for (const Eigen::Vector2d& arm : {Eigen::Vector2d(4, 0), Eigen::Vector2d(0, 4)})
    draw_polyline(bgr, {center_px - arm, center_px + arm}, false, color);
}

void draw_text(cv::Mat& bgr, const std::string& text, const cv::Point& at, double size) {
  cv::putText(bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3, cv::LINE_AA);
  cv::putText(bgr, text, at, cv::FONT_HERSHEY_SIMPLEX, size, {255, 255, 255}, 1, cv::LINE_AA);
}

void draw_text_apart(cv::Mat& bgr, const std::string& text, const cv::Point& at, double size,
                     std::vector<cv::Rect>& others) {
  const cv::Size room = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr) + cv::Size(4, 10);
  const int lowest = std::max(0, bgr.rows - room.height);
  const cv::Point corner(std::clamp(at.x - room.width / 2, 0, std::max(0, bgr.cols - room.width)),
                         std::clamp(at.y - room.height / 2, 0, lowest));
  const auto place = [&]() -> cv::Rect {
    for (int step = 0; step <= lowest; ++step) {
      for (const int y : {corner.y + step, corner.y - step}) {
        const cv::Rect tried({corner.x, y}, room);
        if (y >= 0 && y <= lowest && std::none_of(others.begin(), others.end(), [&](const cv::Rect& other) {
              return (other & tried).area() > 0;
            }))
          return tried;
      }
    }
    return {corner, room};
  };
  others.push_back(place());
  draw_text(bgr, text, {others.back().x, others.back().br().y - 4}, size);
}

double label_scale(int width_px) { return std::clamp(width_px / 1600.0, 0.4, 1.0); }

void draw_ball(cv::Mat& bgr, const Camera& camera, const BallObservation& ball, const std::string& label,
               const cv::Scalar& color) {
  const auto outline = project_outline(camera, ball.cone.axis, std::sin(ball.cone.alpha_rad), 128);
  draw_polyline(bgr, outline, true, {0, 0, 0}, 3);
  draw_polyline(bgr, outline, true, color, 1);
  draw_cross(bgr, ball.outline.center_px, color);
  if (label.empty()) return;
  const double scale = label_scale(bgr.cols), above_px = ball.outline.radius_px + 8 + 10 * scale;
  std::vector<cv::Rect> alone;
  draw_text_apart(bgr, label, cv::Point2d(ball.outline.center_px.x(), ball.outline.center_px.y() - above_px),
                  scale, alone);
}

}  // namespace ballservo
