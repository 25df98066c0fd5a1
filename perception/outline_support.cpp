#include "perception/outline_support.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

double OutlineSupport::quality() const {
  return std::sqrt(std::clamp(arc, 0.0, 1.0) * std::clamp(fill, 0.0, 1.0)) * (1 - leak);
}

double arc_support(const OutlineEdges& edges, const TangentCone& cone, double tolerance_px) {
  int supported = 0;
  for (const EdgePoint& edge : edges.points) {
    if (std::abs(angle_outside(cone, edge.ray)) * edge.px_per_rad <= tolerance_px) ++supported;
  }
  return edges.stretches > 0 ? static_cast<double>(supported) / edges.stretches : 0;
}

OutlineSupport color_support(const cv::Mat& classes, cv::Point window, const RegionMap& regions, int region,
                             const RayTable& rays, const TangentCone& cone, const OutlineEllipse& outline) {
  constexpr double rim_begin = 1.15, rim_end = 1.45;
  const ClassIndex color_class = regions.regions()[static_cast<std::size_t>(region)].color_class;
  const double reach = 1.6 * outline.radius_px + 2;
  const int step = std::max(1, static_cast<int>(outline.radius_px / 20));
  const auto clamped = [](double value, int high) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(high)));
  };
  const int left = clamped(outline.center_px.x() - window.x - reach, classes.cols);
  const int right = clamped(outline.center_px.x() - window.x + reach + 1, classes.cols);
  const int top = clamped(outline.center_px.y() - window.y - reach, classes.rows);
  const int bottom = clamped(outline.center_px.y() - window.y + reach + 1, classes.rows);
  const double cos_disc = std::cos(cone.alpha_rad);
  const double cos_rim_begin = std::cos(rim_begin * cone.alpha_rad),
               cos_rim_end = std::cos(std::min(rim_end * cone.alpha_rad, 3.1));
  long disc = 0, disc_colored = 0, rim = 0, rim_colored = 0;
  for (int v = top; v < bottom; v += step) {
    for (int u = left; u < right; u += step) {
      const auto ray = rays.ray({u + window.x, v + window.y});
      if (!ray) continue;
      const double cosine = cone.axis.dot(*ray);
      const bool in_disc = cosine >= cos_disc, in_rim = cosine < cos_rim_begin && cosine >= cos_rim_end;
      if (!in_disc && !in_rim) continue;
      const bool colored = classes.at<ClassIndex>(v, u) == color_class || regions.region_at(u, v) == region;
      (in_disc ? disc : rim) += 1;
      (in_disc ? disc_colored : rim_colored) += colored ? 1 : 0;
    }
  }
  OutlineSupport support;
  if (disc > 0) support.fill = static_cast<double>(disc_colored) / static_cast<double>(disc);
  if (rim > 0) support.leak = static_cast<double>(rim_colored) / static_cast<double>(rim);
  return support;
}

}  // namespace ballservo
