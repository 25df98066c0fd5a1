#include "perception/edge_points.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr double pi = 3.14159265358979323846;
// A stretch's place is never believed better than this: what the profile model leaves out (texture, shadows).
constexpr double sigma_floor_px = 0.01;

// How the outline runs at one angle: its place in the picture and how fast it moves when the cone opens.
struct OutlineStation {
  double px_per_rad = 0;
  Eigen::Vector2d pixel_px{0, 0};
  bool visible = false;
};

OutlineStation station_at(const Camera& camera, const TangentCone& cone,
                          const Eigen::Matrix<double, 3, 2>& basis, double angle) {
  const Eigen::Vector3d outward = basis * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const Eigen::Vector3d along = basis * Eigen::Vector2d(-std::sin(angle), std::cos(angle));
  const double sine = std::sin(cone.alpha_rad), cosine = std::cos(cone.alpha_rad);
  const Eigen::Vector3d ray = cone.axis * cosine + outward * sine;
  const auto pixel = camera.project(ray);
  const auto jacobian = camera.project_jacobian(ray);
  if (!pixel || !jacobian) return {};
  const Eigen::Vector2d tangent = *jacobian * along;
  const Eigen::Vector2d opening = *jacobian * (outward * cosine - cone.axis * sine);
  const double length = tangent.norm();
  if (!(length > 0)) return {};
  // The part of the motion that is perpendicular to the outline.
  const double across = std::abs(opening.x() * tangent.y() - opening.y() * tangent.x()) / length;
  return {across, *pixel, across > 0 && std::isfinite(across)};
}

// The step's place to a pixel: where the mean intensity changes most between two pixels inside and two
// outside.
double coarse_offset(const std::vector<EdgeSample>& samples, double sign, double reach_px) {
  double best_score = -1, best = 0;
  for (double offset = -reach_px; offset <= reach_px; offset += 0.5) {
    double inside = 0, outside = 0;
    int inside_count = 0, outside_count = 0;
    for (const EdgeSample& sample : samples) {
      const double t = sample.distance_px - offset;
      if (t > -2 && t <= 0) inside += sample.intensity, ++inside_count;
      if (t > 0 && t <= 2) outside += sample.intensity, ++outside_count;
    }
    if (inside_count < 2 || outside_count < 2) continue;
    const double score =
        sign * (inside / inside_count - outside / outside_count) * (1 - 0.1 * std::abs(offset));
    if (score > best_score) {
      best_score = score;
      best = offset;
    }
  }
  return best;
}

}  // namespace

void EdgeMeter::measure(const cv::Mat& bgr, const RayTable& rays, const TangentCone& outline,
                        OutlineEdges& edges) {
  CV_Assert(bgr.type() == CV_8UC3 && bgr.cols == rays.size().width_px && bgr.rows == rays.size().height_px);
  edges.points.clear();
  edges.stretches = edges.stretches_in_picture = 0;
  edges.blur_px = 0;
  const Camera& camera = rays.camera();
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(outline.axis);

  // How many stretches: by the length of the outline.
  const OutlineStation first = station_at(camera, outline, basis, 0);
  if (!first.visible) return;
  const double radius_px = std::sin(outline.alpha_rad) * first.px_per_rad;
  const int stretches = std::clamp(static_cast<int>(2 * pi * radius_px / options_.stretch_length_px),
                                   options_.min_stretches, options_.max_stretches);
  std::vector<OutlineStation> stations(static_cast<std::size_t>(stretches));
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  double least_px_per_rad = first.px_per_rad;
  for (int i = 0; i < stretches; ++i) {
    OutlineStation& station = stations[static_cast<std::size_t>(i)];
    station = station_at(camera, outline, basis, 2 * pi * (i + 0.5) / stretches);
    if (!station.visible) continue;
    low = low.cwiseMin(station.pixel_px);
    high = high.cwiseMax(station.pixel_px);
    least_px_per_rad = std::min(least_px_per_rad, station.px_per_rad);
    const Eigen::Vector2d& p = station.pixel_px;
    if (p.minCoeff() >= 1 && p.x() <= bgr.cols - 2 && p.y() <= bgr.rows - 2) ++edges.stretches_in_picture;
  }
  edges.stretches = stretches;
  if (edges.stretches_in_picture == 0) return;

  // The ring must leave a core for the level inside, also of a small ball.
  const double half_width_px = std::clamp(0.6 * radius_px, 2.5, options_.half_width_px);
  const double half_width_rad = half_width_px / least_px_per_rad;
  const double cos_outer = std::cos(std::min(outline.alpha_rad + half_width_rad, pi));
  const double cos_inner = std::cos(std::max(outline.alpha_rad - half_width_rad, 0.0));
  const double margin = half_width_px + 0.05 * (high - low).maxCoeff() + 2;
  const int left = std::max(0, static_cast<int>(std::clamp(low.x() - margin, 0.0, 1e6)));
  const int top = std::max(0, static_cast<int>(std::clamp(low.y() - margin, 0.0, 1e6)));
  const int right = std::min(bgr.cols - 1, static_cast<int>(std::clamp(high.x() + margin, 0.0, 1e6)));
  const int bottom = std::min(bgr.rows - 1, static_cast<int>(std::clamp(high.y() + margin, 0.0, 1e6)));
  ring_.clear();
  for (int v = top; v <= bottom; ++v) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(v);
    for (int u = left; u <= right; ++u) {
      const Eigen::Vector3d* const ray = rays.pixel_ray(u, v);
      if (!ray) continue;
      const double cosine = outline.axis.dot(*ray);
      if (cosine > cos_inner || cosine < cos_outer) continue;
      const Eigen::Vector2d across = basis.transpose() * *ray;
      const double outside_rad = std::atan2(across.norm(), cosine) - outline.alpha_rad;
      double position = std::atan2(across.y(), across.x()) / (2 * pi);
      position = (position < 0 ? position + 1 : position) * stretches;
      const int stretch = std::min(static_cast<int>(position), stretches - 1);
      // Between the stretches' middles the scale changes linearly.
      const double part = position - stretch - 0.5;
      const int next = (stretch + (part < 0 ? stretches - 1 : 1)) % stretches;
      const OutlineStation& a = stations[static_cast<std::size_t>(stretch)];
      const OutlineStation& b = stations[static_cast<std::size_t>(next)];
      if (!a.visible || !b.visible) continue;
      const double scale = a.px_per_rad + std::abs(part) * (b.px_per_rad - a.px_per_rad);
      const double distance_px = outside_rad * scale;
      if (std::abs(distance_px) <= half_width_px) ring_.push_back({stretch, distance_px, scale, row[u]});
    }
  }
  std::stable_sort(ring_.begin(), ring_.end(),
                   [](const RingPixel& a, const RingPixel& b) { return a.stretch < b.stretch; });

  EdgeProfileOptions profile;
  profile.min_contrast = options_.min_contrast;
  profile.max_offset_px = options_.max_offset_px;
  EdgeProfilePrior prior;
  prior.radius_px = radius_px;
  blurs_.clear();
  for (std::size_t begin = 0, end = 0; begin < ring_.size(); begin = end) {
    const int stretch = ring_[begin].stretch;
    Eigen::Vector3d inside(0, 0, 0), outside(0, 0, 0);
    int inside_count = 0, outside_count = 0;
    for (end = begin; end < ring_.size() && ring_[end].stretch == stretch; ++end) {
      const RingPixel& pixel = ring_[end];
      const Eigen::Vector3d color(pixel.bgr[0], pixel.bgr[1], pixel.bgr[2]);
      if (pixel.distance_px < -1.5) inside += color, ++inside_count;
      if (pixel.distance_px > 1.5) outside += color, ++outside_count;
    }
    if (inside_count < 3 || outside_count < 3) continue;
    // The step is looked at along the line in colour space from what is outside to what is inside.
    const Eigen::Vector3d difference = inside / inside_count - outside / outside_count;
    const double contrast = difference.norm();
    if (!(contrast >= options_.min_contrast)) continue;
    const Eigen::Vector3d direction = difference / contrast;
    samples_.clear();
    for (std::size_t i = begin; i < end; ++i) {
      const cv::Vec3b& c = ring_[i].bgr;
      samples_.push_back({ring_[i].distance_px, direction.dot(Eigen::Vector3d(c[0], c[1], c[2]))});
    }
    const double reach_px = std::min(options_.max_offset_px, half_width_px - 2);
    const auto fit = fit_edge_profile(samples_, coarse_offset(samples_, 1, reach_px), prior, profile);
    if (!fit) continue;
    const OutlineStation& station = stations[static_cast<std::size_t>(stretch)];
    const double angle = 2 * pi * (stretch + 0.5) / stretches;
    // A blurred disc's half level lies inside its edge by s^2 / 2r, the mean curvature's share of the
    // diffusion.
    const double distance_px = fit->offset_px + fit->blur_px * fit->blur_px / (2 * radius_px);
    const double edge_rad = outline.alpha_rad + distance_px / station.px_per_rad;
    EdgePoint point;
    point.ray = outline.axis * std::cos(edge_rad) +
                basis * Eigen::Vector2d(std::cos(angle), std::sin(angle)) * std::sin(edge_rad);
    point.px_per_rad = station.px_per_rad;
    point.sigma_px = std::hypot(fit->sigma_px, sigma_floor_px);
    point.angle_rad = angle;
    point.contrast = std::abs(fit->step);
    edges.points.push_back(point);
    blurs_.push_back(fit->blur_px);
  }
  if (!blurs_.empty()) {
    const auto middle = blurs_.begin() + static_cast<std::ptrdiff_t>(blurs_.size() / 2);
    std::nth_element(blurs_.begin(), middle, blurs_.end());
    edges.blur_px = *middle;
  }
}

}  // namespace ballservo
