#include "app/comparison/estimators/algebraic_circles.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace ballservo {
namespace {

// The points about their centroid, in units of their own size, so that the moments are of order 1.
struct Moments {
  Eigen::Vector2d centroid_px{0, 0};
  double scale_px = 0;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();  // weighted mean of (z, x, y, 1)(z, x, y, 1)^T
};

std::optional<Moments> moments_of(const std::vector<RingPixel>& points) {
  Moments moments;
  double weights = 0;
  int used = 0;
  for (const RingPixel& point : points) {
    if (!(point.weight > 0)) continue;
    if (!point.position_px.allFinite() || !std::isfinite(point.weight)) return std::nullopt;
    moments.centroid_px += point.weight * point.position_px;
    weights += point.weight;
    ++used;
  }
  if (used < 3) return std::nullopt;
  moments.centroid_px /= weights;
  for (const RingPixel& point : points) {
    if (point.weight > 0)
      moments.scale_px += point.weight * (point.position_px - moments.centroid_px).squaredNorm();
  }
  moments.scale_px = std::sqrt(moments.scale_px / weights);
  if (!(moments.scale_px > 0)) return std::nullopt;
  for (const RingPixel& point : points) {
    if (!(point.weight > 0)) continue;
    const Eigen::Vector2d p = (point.position_px - moments.centroid_px) / moments.scale_px;
    const Eigen::Vector4d row(p.squaredNorm(), p.x(), p.y(), 1);
    moments.matrix += point.weight / weights * row * row.transpose();
  }
  return moments;
}

// The circle of A z + B x + C y + D = 0.
std::optional<UndistortedCircle> undistorted_circle(const Moments& moments, const Eigen::Vector4d& a) {
  const Eigen::Vector2d center = -a.segment<2>(1) / (2 * a[0]);
  const double radius2 = center.squaredNorm() - a[3] / a[0];
  if (!center.allFinite() || !(radius2 > 0) || !std::isfinite(radius2)) return std::nullopt;
  return UndistortedCircle{moments.centroid_px + moments.scale_px * center,
                           moments.scale_px * std::sqrt(radius2)};
}

// Points on a line leave the two directions' moments with an eigenvalue of 0.
bool on_a_line(const Moments& moments) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(moments.matrix.block<2, 2>(1, 1));
  return !(eigen.eigenvalues()[0] > 1e-12 * eigen.eigenvalues()[1]);
}

}  // namespace

std::optional<UndistortedCircle> kasa_circle(const std::vector<RingPixel>& points) {
  const auto moments = moments_of(points);
  if (!moments || on_a_line(*moments)) return std::nullopt;
  const Eigen::Matrix4d& m = moments->matrix;
  const Eigen::Vector3d rest = m.bottomRightCorner<3, 3>().ldlt().solve(-m.block<3, 1>(1, 0));
  return undistorted_circle(*moments, {1, rest[0], rest[1], rest[2]});
}

std::optional<UndistortedCircle> taubin_circle(const std::vector<RingPixel>& points) {
  const auto moments = moments_of(points);
  if (!moments || on_a_line(*moments)) return std::nullopt;
  const Eigen::Matrix4d& m = moments->matrix;
  // About the centroid D = -A mean(z); what is left is a symmetric 3 x 3 problem in (2 A sqrt(mean z), B, C),
  // whose constraint is the unit sphere: sum |grad P|^2 = 4 A^2 mean(z) + B^2 + C^2.
  const double mean_z = m(0, 3);
  Eigen::Matrix3d s = m.topLeftCorner<3, 3>();
  s(0, 0) -= mean_z * mean_z;
  const double half = 1 / (2 * std::sqrt(mean_z));
  s.row(0) *= half;
  s.col(0) *= half;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(s);
  const Eigen::Vector3d best = eigen.eigenvectors().col(0);
  const double a = best[0] * half;
  return undistorted_circle(*moments, {a, best[1], best[2], -a * mean_z});
}

}  // namespace ballservo
