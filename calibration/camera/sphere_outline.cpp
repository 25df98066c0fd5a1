#include "calibration/camera/sphere_outline.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr double two_pi = 6.283185307179586;
// Samples of the outline for its area and centroid: it is a smooth closed curve and its tangents are exact,
// so the trapezoidal rule converges exponentially; 48 samples leave less than 1e-9 px for the lenses of ours.
constexpr int outline_samples = 48;

bool sees_sphere(const Eigen::Vector3d& p_C, double radius_m) {
  return p_C.allFinite() && std::isfinite(radius_m) && radius_m > 0 && p_C.norm() > radius_m;
}

// The tangent cone of a sphere: unit rays ray(angle) around its axis.
struct TangentCone {
  Eigen::Vector3d axis;
  Eigen::Matrix<double, 3, 2> basis;
  double sin_alpha, cos_alpha;

  TangentCone(const Eigen::Vector3d& p_C, double radius_m)
      : axis(p_C.normalized()),
        basis(perpendicular_basis(p_C)),
        sin_alpha(radius_m / p_C.norm()),
        cos_alpha(std::sqrt((1 - sin_alpha) * (1 + sin_alpha))) {}

  Eigen::Vector3d ray(double angle) const {
    return axis * cos_alpha + basis * Eigen::Vector2d(std::cos(angle), std::sin(angle)) * sin_alpha;
  }
  Eigen::Vector3d ray_derivative(double angle) const {
    return basis * Eigen::Vector2d(-std::sin(angle), std::cos(angle)) * sin_alpha;
  }
};

}  // namespace

Eigen::Matrix<double, 3, 2> perpendicular_basis(const Eigen::Vector3d& direction) {
  const Eigen::Vector3d axis = direction.normalized();
  // Where the direction is the x axis itself, any perpendicular does; -z keeps the pair right-handed with y.
  const Eigen::Vector3d toward_x =
      std::abs(axis.x()) < 0.999 ? Eigen::Vector3d::UnitX().eval() : (-Eigen::Vector3d::UnitZ()).eval();
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) = (toward_x - axis * axis.dot(toward_x)).normalized();
  basis.col(1) = axis.cross(basis.col(0));
  return basis;
}

std::vector<Eigen::Vector3d> outline_rays(const Eigen::Vector3d& p_C, double radius_m, int count) {
  std::vector<Eigen::Vector3d> rays;
  if (count < 1 || !sees_sphere(p_C, radius_m)) return rays;
  const TangentCone cone(p_C, radius_m);
  rays.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) rays.push_back(cone.ray(two_pi * i / count));
  return rays;
}

std::vector<Eigen::Vector2d> project_outline(const Camera& camera, const Eigen::Vector3d& p_C,
                                             double radius_m, int count) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3d& ray : outline_rays(p_C, radius_m, count)) {
    const auto pixel = camera.project(ray);
    if (!pixel) return {};
    points.push_back(*pixel);
  }
  return points;
}

std::optional<OutlineEllipse> project_sphere(const Camera& camera, const Eigen::Vector3d& p_C,
                                             double radius_m) {
  if (!sees_sphere(p_C, radius_m)) return std::nullopt;
  const TangentCone cone(p_C, radius_m);
  const auto center = camera.project(p_C);
  if (!center) return std::nullopt;
  // Green's theorem on the closed curve, about the projected centre so that no digits are lost.
  double area = 0;
  Eigen::Vector2d moment(0, 0);
  for (int i = 0; i < outline_samples; ++i) {
    const double angle = two_pi * i / outline_samples;
    const Eigen::Vector3d ray = cone.ray(angle);
    const auto pixel = camera.project(ray);
    const auto jacobian = camera.project_jacobian(ray);
    if (!pixel || !jacobian) return std::nullopt;
    const Eigen::Vector2d p = *pixel - *center;
    const Eigen::Vector2d tangent = *jacobian * cone.ray_derivative(angle) * (two_pi / outline_samples);
    area += 0.5 * (p.x() * tangent.y() - p.y() * tangent.x());
    moment += 0.5 * Eigen::Vector2d(p.x() * p.x() * tangent.y(), -p.y() * p.y() * tangent.x());
  }
  if (!std::isfinite(area) || area == 0 || !moment.allFinite()) return std::nullopt;
  return OutlineEllipse{*center + moment / area, std::sqrt(std::abs(area) / (two_pi / 2))};
}

std::optional<Eigen::Vector3d> sphere_from_rays(const std::vector<Eigen::Vector3d>& rays, double radius_m) {
  if (rays.empty()) return std::nullopt;
  return sphere_from_rays(
      Eigen::Map<const Eigen::Matrix3Xd>(rays.front().data(), 3, static_cast<Eigen::Index>(rays.size())),
      radius_m);
}

std::optional<Eigen::Vector3d> sphere_from_rays(const Eigen::Ref<const Eigen::Matrix3Xd>& rays,
                                                double radius_m) {
  if (rays.cols() < 3 || !(radius_m > 0)) return std::nullopt;
  // Rays of a small ball are nearly parallel: solve around their mean direction m, n = a m + B t, so that
  // the columns of the system are of like size. u.n = 1 becomes (u.m) a + (B' u).t = 1.
  Eigen::Vector3d mean(0, 0, 0);
  for (Eigen::Index i = 0; i < rays.cols(); ++i) mean += rays.col(i);
  if (!mean.allFinite() || mean.norm() < 1e-12) return std::nullopt;
  mean.normalize();
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(mean);
  double spread = 0;
  for (Eigen::Index i = 0; i < rays.cols(); ++i)
    spread = std::max(spread, (basis.transpose() * rays.col(i)).norm());
  if (!(spread > 0)) return std::nullopt;
  // With q = basis' u (size of the spread) and 1 - u.m = q^2 / (1 + u.m):
  // a - 1 =: e spread^2, t =: f spread; e spread^2 (u.m) + f.q spread = q^2 / (1 + u.m); divide by spread^2.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < rays.cols(); ++i) {
    const Eigen::Vector3d ray = rays.col(i);
    const Eigen::Vector2d q = basis.transpose() * ray / spread;
    const Eigen::Vector3d row(ray.dot(mean), q.x(), q.y());
    normal += row * row.transpose();
    right += row * (q.squaredNorm() / (1 + row.x()));
  }
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(normal);
  const Eigen::Vector3d pivots = ldlt.vectorD();
  if (!(pivots.minCoeff() > 1e-13 * pivots.maxCoeff())) return std::nullopt;
  const Eigen::Vector3d solution = ldlt.solve(right);
  const Eigen::Vector2d t = solution.tail<2>() * spread;
  const double excess = solution(0) * spread * spread;  // a - 1
  // |n|^2 - 1 = tan^2(alpha), and n = C / sqrt(|C|^2 - R^2) gives C = n R / tan(alpha).
  const double tan_squared = excess * (2 + excess) + t.squaredNorm();
  if (!(tan_squared > 0) || !std::isfinite(tan_squared)) return std::nullopt;
  const Eigen::Vector3d n = (1 + excess) * mean + basis * t;
  return n * (radius_m / std::sqrt(tan_squared));
}

std::optional<Eigen::Vector3d> sphere_from_outline(const Camera& camera,
                                                   const std::vector<Eigen::Vector2d>& outline_px,
                                                   double radius_m) {
  std::vector<Eigen::Vector3d> rays;
  for (const Eigen::Vector2d& pixel : outline_px) {
    const auto ray = camera.unproject(pixel);
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
  }
  return sphere_from_rays(rays, radius_m);
}

bool is_inside_picture(const std::vector<Eigen::Vector2d>& outline_px, ImageSize size, double margin_px) {
  return !outline_px.empty() &&
         std::all_of(outline_px.begin(), outline_px.end(),
                     [&](const Eigen::Vector2d& p) { return is_inside_picture(p, size, margin_px); });
}

}  // namespace ballservo
