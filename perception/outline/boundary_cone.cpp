#include "perception/outline/boundary_cone.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// So many points place a cone well enough to measure edges around it, and so near a step has done enough.
constexpr std::size_t points_for_a_start = 64;
constexpr double half_pi = 1.57079632679489662;
constexpr double settled_start_px = 0.5, settled_weights_px = 0.05;

}  // namespace

Eigen::Vector3d ray_of(const BoundaryPoint& point, double focal_px) {
  return Eigen::Vector3d(static_cast<double>(point.position_px.x()),
                         static_cast<double>(point.position_px.y()), focal_px)
      .normalized();
}

double outline_tolerance_px(double radius_px) { return 0.5 + 0.025 * radius_px; }

TangentCone BoundaryCone::rough(const TangentCone& voted, const std::vector<BoundaryPoint>& points,
                                double focal_px) {
  TangentCone cone = voted;
  for (int i = 0; i < 2; ++i) {
    const double band_rad = 0.15 * cone.alpha_rad + 1 / focal_px;
    const double cosine_inner = std::cos(std::max(0.0, cone.alpha_rad - band_rad)),
                 cosine_outer = std::cos(cone.alpha_rad + band_rad);
    rays_.clear();
    for (const BoundaryPoint& p : points) {
      const Eigen::Vector3d ray = ray_of(p, focal_px);
      const double cosine = cone.axis.dot(ray);
      if (cosine <= cosine_inner && cosine >= cosine_outer) rays_.push_back(ray);
    }
    const auto center = sphere_from_rays(rays_, 1);
    const auto found = center ? TangentCone::of_sphere(*center, 1) : std::nullopt;
    if (!found || !(std::abs(found->alpha_rad / voted.alpha_rad - 1) < 0.3)) return voted;
    cone = *found;
  }
  return cone;
}

std::optional<TangentCone> BoundaryCone::robust(const TangentCone& start,
                                                const std::vector<BoundaryPoint>& points, double focal_px,
                                                double oval_fraction) {
  TangentCone cone = start;
  for (int i = 0; i < 2; ++i) {
    const double band_rad = 0.15 * cone.alpha_rad + 1 / focal_px;
    edges_.clear();
    for (std::size_t k = 0; k < points.size(); k += 1 + points.size() / points_for_a_start) {
      EdgePoint edge;
      edge.ray = ray_of(points[k], focal_px);
      if (std::abs(angle_outside(cone, edge.ray)) > band_rad) continue;
      edge.px_per_rad = focal_px;
      edge.sigma_px = 0.5;
      edges_.push_back(edge);
    }
    const auto step_rad = weights_.set(cone, edges_, 0.3, oval_fraction, settled_weights_px);
    if (!step_rad) return std::nullopt;
    cone = moved(cone, *step_rad);
    if (!(cone.alpha_rad > 0) || !(cone.alpha_rad < half_pi)) return std::nullopt;
    if (step_rad->lpNorm<1>() * focal_px < settled_start_px) break;
  }
  return cone;
}

}  // namespace ballservo
