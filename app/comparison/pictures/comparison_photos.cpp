#include "app/comparison/pictures/comparison_photos.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/comparison/pictures/rendered_frame.hpp"
#include "app/report/overlay.hpp"

namespace ballservo {
namespace {

// What is shown of a picture, and how large.
struct Crop {
  cv::Rect box;
  double scale = 1;

  Eigen::Vector2d at(const Eigen::Vector2d& p) const {
    return scale * (p - Eigen::Vector2d(box.x, box.y) + Eigen::Vector2d(0.5, 0.5)) -
           Eigen::Vector2d(0.5, 0.5);
  }
};

Crop crop_around(const cv::Mat& picture, const std::optional<OutlineEllipse>& ball, int width_px) {
  const cv::Rect everything({0, 0}, picture.size());
  Crop crop{everything, 1};
  if (ball && ball->center_px.allFinite() && std::isfinite(ball->radius_px)) {
    const int reach_px = std::max(12, static_cast<int>(2.2 * ball->radius_px));
    const cv::Rect wanted = square_around(ball->center_px, reach_px) & everything;
    if (!wanted.empty()) crop.box = wanted;
  }
  crop.scale = static_cast<double>(width_px) / crop.box.width;
  return crop;
}

cv::Mat enlarged(const cv::Mat& picture, const Crop& crop) {
  cv::Mat large;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(crop.scale * crop.box.width))),
                      std::max(1, static_cast<int>(std::lround(crop.scale * crop.box.height))));
  cv::resize(picture(crop.box), large, size, 0, 0, crop.scale >= 1 ? cv::INTER_NEAREST : cv::INTER_AREA);
  return large;
}

void draw_outline(cv::Mat& large, const Crop& crop, const OutlineEllipse& outline, const cv::Scalar& color,
                  int thickness) {
  if (!outline.center_px.allFinite() || !(outline.radius_px < 1e5)) return;
  draw_circle(large, crop.at(outline.center_px), crop.scale * outline.radius_px, color, thickness);
}

cv::Scalar color_of(const FitMethod& method) {
  if (method.is_peer) return {200, 60, 200};
  if (method.points == MethodPoints::edges) return {230, 130, 30};
  if (method.name == "kasa" || method.name == "taubin") return {80, 180, 60};
  return method.points == MethodPoints::ring ? cv::Scalar(20, 140, 240) : cv::Scalar(150, 150, 150);
}

}  // namespace

cv::Mat example_photo(const ComparisonPicture& picture) {
  return enlarged(picture.bgr, crop_around(picture.bgr, picture.truth.outline, 220));
}

cv::Mat outlines_photo(const ComparisonPicture& picture, const ComparisonRecord& record,
                       const MethodList& methods) {
  std::optional<OutlineEllipse> ball = record.truth.outline;
  for (const auto& fit : record.fits) {
    if (!ball && fit) ball = fit->outline;
  }
  const Crop crop = crop_around(picture.bgr, ball, 420);
  cv::Mat large = enlarged(picture.bgr, crop);
  if (record.truth.outline) draw_outline(large, crop, *record.truth.outline, {255, 255, 255}, 2);
  // What runs on line lies on top.
  for (const bool on_line : {false, true}) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      if ((methods[m]->name == "sphere_one_step") == on_line && record.fits[m])
        draw_outline(large, crop, record.fits[m]->outline, color_of(*methods[m]), 1);
    }
  }
  return large;
}

}  // namespace ballservo
