#include "app/comparison/estimators/position_bound.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"
#include "perception/outline/cone_fit.hpp"
#include "perception/outline/edge_model.hpp"

namespace ballservo {
namespace {

constexpr int color_channels = 3, terms = 4;  // of the model: O, A, B, D
constexpr double segment_px = 8;              // of the outline has one background, contrast and shading
constexpr int fewest_segments = 8;            // of a small ball
constexpr double reach_sigmas = 3, beyond_edge_px = 4;  // how far from the outline pixels count
constexpr double reach_inside = 0.6;                    // of the radius, at most
constexpr double least_seen = 0.5;                      // of a segment's pixels

using Terms = Eigen::Matrix<double, terms, 1>;
using Levels = Eigen::Matrix<double, color_channels, 1>;
using Global = Eigen::Vector4d;                 // p_C, s
constexpr int locals = 2 * color_channels + 2;  // O and A of each channel, slopes of root and ramp
using Local = Eigen::Matrix<double, locals, 1>;

double edge_width_px(const BoundScene& scene) { return std::sqrt(scene.blur_px * scene.blur_px + 1.0 / 12); }

// A pixel near the outline, and how the outline's distance from it changes as the ball moves.
struct OutlinePixel {
  double distance_px = 0;
  Eigen::Vector3d slope{0, 0, 0};  // d distance / d p_C, px per m
  Levels clean;
};

struct ArcSegment {
  std::vector<OutlinePixel> pixels;
  int expected = 0;  // as many if nothing were hidden
};

std::optional<OutlinePixel> outline_pixel(const BoundScene& scene, const TangentCone& cone, int u, int v) {
  const Eigen::Vector2d at(u, v);
  const auto ray = scene.camera.unproject(at);
  if (!ray) return std::nullopt;
  Eigen::Vector2d rad_per_px;
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d half = 0.5 * Eigen::Vector2d::Unit(axis);
    const auto low = scene.camera.unproject(at - half, *ray), high = scene.camera.unproject(at + half, *ray);
    if (!low || !high) return std::nullopt;
    rad_per_px[axis] = angle_outside(cone, *high) - angle_outside(cone, *low);
  }
  const double px_per_rad = 1 / rad_per_px.norm();
  const double cosine = ray->dot(cone.axis), sine = ray->cross(cone.axis).norm();
  OutlinePixel pixel;
  pixel.distance_px = px_per_rad * angle_outside(cone, *ray);
  if (sine > 0)
    pixel.slope = px_per_rad / scene.p_CB.norm() *
                  (std::tan(cone.alpha_rad) * cone.axis - (*ray - cosine * cone.axis) / sine);
  return pixel;
}

// The ball's outline cut into segments, with the pixels near each.
std::vector<ArcSegment> collect(const BoundScene& scene, const TangentCone& cone,
                                const OutlineEllipse& outline) {
  const double reach_px = reach_sigmas * edge_width_px(scene) + beyond_edge_px;
  const double inside_px = std::min(reach_px, reach_inside * outline.radius_px);
  const int count =
      std::max(fewest_segments, static_cast<int>(std::ceil(2 * M_PI * outline.radius_px / segment_px)));
  std::vector<ArcSegment> segments(static_cast<std::size_t>(count));
  cv::Mat clean, unhidden;
  scene.clean_bgr.convertTo(clean, CV_32FC3);
  if (!scene.unhidden.empty()) {  // nor where the blur of what hides reaches
    const int reach = static_cast<int>(std::ceil(reach_sigmas * edge_width_px(scene)));
    cv::erode(scene.unhidden, unhidden,
              cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  }
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(scene.p_CB);
  // Off the axis the outline is longer than its mean radius says.
  const int around = static_cast<int>(1.5 * outline.radius_px + reach_px) + 2;
  const int u0 = static_cast<int>(outline.center_px.x()), v0 = static_cast<int>(outline.center_px.y());
  for (int v = v0 - around; v <= v0 + around; ++v) {
    for (int u = u0 - around; u <= u0 + around; ++u) {
      auto pixel = outline_pixel(scene, cone, u, v);
      if (!pixel || pixel->distance_px > reach_px || pixel->distance_px < -inside_px) continue;
      const Eigen::Vector2d across = basis.transpose() * *scene.camera.unproject({u, v});
      const double turn = std::atan2(across.y(), across.x()) / (2 * M_PI);
      const int which = std::clamp(static_cast<int>((turn - std::floor(turn)) * count), 0, count - 1);
      ArcSegment& segment = segments[static_cast<std::size_t>(which)];
      ++segment.expected;
      if (u < 0 || v < 0 || u >= clean.cols || v >= clean.rows) continue;
      if (!unhidden.empty() && unhidden.at<std::uint8_t>(v, u) == 0) continue;
      const cv::Vec3f level = clean.at<cv::Vec3f>(v, u);
      pixel->clean = Levels(level[0], level[1], level[2]);
      segment.pixels.push_back(*pixel);
    }
  }
  return segments;
}

// The model's terms at a pixel, and their derivatives by the outline's place (outward) and by s.
struct TermsAt {
  Terms value, by_place, by_width;
};

TermsAt terms_at(double distance_px, double s) {
  const double x = -distance_px / s, root_s = std::sqrt(s);
  const BlurredBasis basis = blurred_basis(x);
  TermsAt at;
  at.value << 1, basis.step, root_s * basis.root, s * basis.ramp;
  at.by_place << 0, basis.step_slope / s, basis.root_slope / root_s, basis.ramp_slope;
  at.by_width << 0, -x * basis.step_slope / s, 0.5 * basis.root / root_s - x * basis.root_slope / root_s,
      basis.step_slope;
  return at;
}

// What the estimator does not know of a segment: columns of dI_c / d(nuisance).
Local local_row(const BoundNuisances& unknown, int channel, const Terms& value, double ball_level) {
  Local row = Local::Zero();
  if (unknown.background) row[channel] = value[0];
  if (unknown.contrast) row[color_channels + channel] = value[1];
  if (unknown.shading) row.tail<2>() = ball_level * value.tail<2>();
  return row;
}

// Of p_C and s, the segment's own nuisances eliminated.
Eigen::Matrix4d information(const ArcSegment& segment, const BoundScene& scene,
                            const BoundNuisances& unknown) {
  const double s = edge_width_px(scene);
  const auto pixels = static_cast<Eigen::Index>(segment.pixels.size());
  std::vector<TermsAt> at;
  Eigen::MatrixXd values(pixels, terms), levels(pixels, color_channels);
  for (Eigen::Index i = 0; i < pixels; ++i) {
    const OutlinePixel& pixel = segment.pixels[static_cast<std::size_t>(i)];
    at.push_back(terms_at(pixel.distance_px, s));
    values.row(i) = at.back().value;
    levels.row(i) = pixel.clean;
  }
  const Eigen::Matrix<double, terms, color_channels> profile =
      values.completeOrthogonalDecomposition().solve(levels);
  Eigen::Matrix4d global = Eigen::Matrix4d::Zero();
  Eigen::Matrix<double, 4, locals> mixed = Eigen::Matrix<double, 4, locals>::Zero();
  Eigen::Matrix<double, locals, locals> local = Eigen::Matrix<double, locals, locals>::Zero();
  for (Eigen::Index i = 0; i < pixels; ++i) {
    const OutlinePixel& pixel = segment.pixels[static_cast<std::size_t>(i)];
    const TermsAt& term = at[static_cast<std::size_t>(i)];
    for (int c = 0; c < color_channels; ++c) {
      const double level = pixel.clean[c];
      if (level <= 0 || level >= 255) continue;  // saturated: it tells nothing
      const double weight = 1 / (scene.read_noise * scene.read_noise + scene.shot_noise * level + 1.0 / 12);
      Global row;
      row << -term.by_place.dot(profile.col(c)) * pixel.slope, 0;
      if (unknown.blur) row[3] = term.by_width.dot(profile.col(c));
      const Local own = local_row(unknown, c, term.value, profile(0, c) + profile(1, c));
      global += weight * row * row.transpose();
      mixed += weight * row * own.transpose();
      local += weight * own * own.transpose();
    }
  }
  return global - mixed * local.completeOrthogonalDecomposition().solve(mixed.transpose());
}

}  // namespace

std::optional<Eigen::Matrix3d> position_bound(const BoundScene& scene, const BoundNuisances& unknown) {
  const auto outline = project_sphere(scene.camera, scene.p_CB, scene.radius_m);
  const auto cone = TangentCone::of_sphere(scene.p_CB, scene.radius_m);
  if (!outline || !cone) return std::nullopt;
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  for (const ArcSegment& segment : collect(scene, *cone, *outline)) {
    if (static_cast<double>(segment.pixels.size()) >= std::max(1.0, least_seen * segment.expected))
      sum += information(segment, scene, unknown);
  }
  Eigen::Matrix3d place = sum.topLeftCorner<3, 3>();
  if (unknown.blur && sum(3, 3) > 0) {
    const Eigen::Vector3d mixed = sum.topRightCorner<3, 1>();
    place -= mixed * mixed.transpose() / sum(3, 3);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(place);
  if (!(eigen.eigenvalues()[0] > 1e-12 * eigen.eigenvalues()[2])) return std::nullopt;
  const Eigen::Matrix3d covariance = place.inverse();
  if (!(covariance.trace() < scene.p_CB.squaredNorm())) return std::nullopt;
  return covariance;
}

}  // namespace ballservo
