#include "perception/outline_support.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {
namespace {

constexpr double pi = 3.14159265358979323846;

// How many of a zone's pixels have the ball's colour.
struct Share {
  int pixels = 0, colored = 0;
  void add(bool is_colored) {
    ++pixels;
    colored += is_colored ? 1 : 0;
  }
  double fraction(double of_nothing) const {
    return pixels > 0 ? static_cast<double>(colored) / pixels : of_nothing;
  }
};

}  // namespace

double OutlineSupport::quality() const {
  return std::sqrt(std::clamp(arc, 0.0, 1.0) * std::clamp(fill, 0.0, 1.0)) * (1 - leak) * (1 - leak);
}

OutlineSectors edge_sectors(const OutlineEdges& edges, const ConeFit& fit, double tolerance_px) {
  OutlineSectors sectors(static_cast<std::size_t>(edges.stretches), false);
  for (const EdgePoint& edge : edges.points) {
    if (std::abs(angle_outside(fit, edge.ray)) * edge.px_per_rad > tolerance_px) continue;
    const double turn = edge.angle_rad / (2 * pi);
    sectors[std::min(sectors.size() - 1,
                     static_cast<std::size_t>(turn * static_cast<double>(sectors.size())))] = true;
  }
  return sectors;
}

OutlineSupport outline_support(const OutlineSectors& edges, const cv::Mat& classes, cv::Point window,
                               const RegionMap& regions, int region, const RayTable& rays,
                               const TangentCone& cone, const OutlineEllipse& outline) {
  // Just inside and just outside the outline, clear of its blur; and a wider rim for what runs on.
  const double clear = std::max(0.08, 1.2 / outline.radius_px);
  const std::array<double, 6> edges_of_zones{1,         1 - clear - 0.2, 1 - clear,
                                             1 + clear, 1 + clear + 0.2, 1 + clear + 0.35};
  std::array<double, 6> cosines;
  for (std::size_t i = 0; i < cosines.size(); ++i)
    cosines[i] = std::cos(std::min(edges_of_zones[i] * cone.alpha_rad, pi));
  const ClassIndex color_class = regions.regions()[static_cast<std::size_t>(region)].color_class;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);

  const double reach = 1.6 * outline.radius_px + 3;
  const int step = std::max(1, static_cast<int>(outline.radius_px / 20));
  const auto clamped = [](double value, int high) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(high)));
  };
  const int left = clamped(outline.center_px.x() - window.x - reach, classes.cols);
  const int right = clamped(outline.center_px.x() - window.x + reach + 1, classes.cols);
  const int top = clamped(outline.center_px.y() - window.y - reach, classes.rows);
  const int bottom = clamped(outline.center_px.y() - window.y + reach + 1, classes.rows);
  Share disc, rim;
  std::vector<Share> inside(edges.size()), outside(edges.size());
  for (int v = top; v < bottom; v += step) {
    for (int u = left; u < right; u += step) {
      const Eigen::Vector3d* const ray = rays.pixel_ray(u + window.x, v + window.y);
      if (!ray) continue;
      const double cosine = cone.axis.dot(*ray);
      if (cosine < cosines[5]) continue;
      const bool colored = classes.at<ClassIndex>(v, u) == color_class || regions.region_at(u, v) == region;
      if (cosine >= cosines[0]) disc.add(colored);
      if (cosine < cosines[3]) rim.add(colored);
      const bool just_inside = cosine < cosines[1] && cosine >= cosines[2],
                 just_outside = cosine < cosines[3] && cosine >= cosines[4];
      if (edges.empty() || (!just_inside && !just_outside)) continue;
      const Eigen::Vector2d across = basis.transpose() * *ray;
      const double turn = std::atan2(across.y(), across.x()) / (2 * pi);
      const std::size_t sector = std::min(
          edges.size() - 1,
          static_cast<std::size_t>((turn < 0 ? turn + 1 : turn) * static_cast<double>(edges.size())));
      (just_inside ? inside : outside)[sector].add(colored);
    }
  }
  OutlineSupport support;
  support.fill = disc.fraction(0);
  support.leak = rim.fraction(0);
  int supported = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i] && inside[i].fraction(1) >= 0.5 && outside[i].fraction(0) <= 0.5) ++supported;
  }
  if (!edges.empty()) support.arc = static_cast<double>(supported) / static_cast<double>(edges.size());
  return support;
}

}  // namespace ballservo
