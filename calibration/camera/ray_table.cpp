#include "calibration/camera/ray_table.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace ballservo {
namespace {

// Outlines may reach a little beyond the picture, and the cubic needs two more pixels there.
constexpr int table_margin_px = 6;
constexpr double min_cos_undistorted = 0.08715574274765817;  // 85 degrees

/// Weights of the four neighbours at -1, 0, 1, 2 (Catmull and Rom, 1974): they reproduce cubics' values and
/// slopes to third order, where a straight line between pixels would err by 1e-3 px in a fisheye picture.
std::array<double, 4> cubic_weights(double t) {
  return {0.5 * t * (-1 + t * (2 - t)), 1 + 0.5 * t * t * (3 * t - 5), 0.5 * t * (1 + t * (4 - 3 * t)),
          0.5 * t * t * (t - 1)};
}

std::array<double, 4> cubic_slopes(double t) {
  return {0.5 * (-1 + t * (4 - 3 * t)), 0.5 * t * (9 * t - 10), 0.5 * (1 + t * (8 - 9 * t)),
          0.5 * t * (3 * t - 2)};
}

struct Patch {
  const Eigen::Vector3d* corner = nullptr;  // upper left of 4 x 4
  double s = 0, t = 0;
};

}  // namespace

RayTable::RayTable(const Camera& camera)
    : camera_(camera),
      margin_px_(table_margin_px),
      stride_(camera.size().width_px + 2 * table_margin_px),
      rows_(camera.size().height_px + 2 * table_margin_px) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  rays_.resize(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(rows_));
  for (int row = 0; row < rows_; ++row) {
    std::optional<Eigen::Vector3d> last;
    for (int column = 0; column < stride_; ++column) {
      const Eigen::Vector2d pixel(column - margin_px_, row - margin_px_);
      last = last ? camera_.unproject(pixel, *last) : camera_.unproject(pixel);
      rays_[static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_) +
            static_cast<std::size_t>(column)] = last.value_or(Eigen::Vector3d::Constant(nan));
    }
  }
}

namespace {

/// The 4 x 4 rays around a position; nothing outside the table.
std::optional<Patch> patch_at(const Eigen::Vector2d& pixel_px, const std::vector<Eigen::Vector3d>& rays,
                              int margin_px, int stride, int rows) {
  const double column = pixel_px.x() + margin_px, row = pixel_px.y() + margin_px;
  if (!(column >= 1 && column < stride - 2 && row >= 1 && row < rows - 2)) return std::nullopt;
  const int left = static_cast<int>(column), top = static_cast<int>(row);
  return Patch{rays.data() + static_cast<std::size_t>(top - 1) * static_cast<std::size_t>(stride) +
                   static_cast<std::size_t>(left - 1),
               column - left, row - top};
}

Eigen::Vector3d blend(const Patch& patch, int stride, const std::array<double, 4>& across,
                      const std::array<double, 4>& down) {
  Eigen::Vector3d sum(0, 0, 0);
  const Eigen::Vector3d* row = patch.corner;
  for (std::size_t i = 0; i < 4; ++i, row += stride)
    sum += down[i] * (across[0] * row[0] + across[1] * row[1] + across[2] * row[2] + across[3] * row[3]);
  return sum;
}

}  // namespace

std::optional<Eigen::Vector3d> RayTable::ray(const Eigen::Vector2d& pixel_px) const {
  const auto patch = patch_at(pixel_px, rays_, margin_px_, stride_, rows_);
  if (!patch) return std::nullopt;
  const Eigen::Vector3d sum = blend(*patch, stride_, cubic_weights(patch->s), cubic_weights(patch->t));
  const double norm = sum.norm();
  // At the rim of a fisheye's circle some of the 16 rays are missing: there the lens is solved anew.
  if (!std::isfinite(norm)) return camera_.unproject(pixel_px);
  return sum / norm;
}

std::optional<Eigen::Matrix<double, 3, 2>> RayTable::ray_jacobian(const Eigen::Vector2d& pixel_px) const {
  const auto patch = patch_at(pixel_px, rays_, margin_px_, stride_, rows_);
  if (!patch) return std::nullopt;
  const auto across = cubic_weights(patch->s), down = cubic_weights(patch->t);
  const Eigen::Vector3d sum = blend(*patch, stride_, across, down);
  const double norm = sum.norm();
  Eigen::Matrix<double, 3, 2> jacobian;
  if (std::isfinite(norm)) {
    jacobian.col(0) = blend(*patch, stride_, cubic_slopes(patch->s), down);
    jacobian.col(1) = blend(*patch, stride_, across, cubic_slopes(patch->t));
    const Eigen::Vector3d unit = sum / norm;
    const Eigen::RowVector2d along = unit.transpose() * jacobian;
    return (jacobian - unit * along) / norm;
  }
  const auto ray = camera_.unproject(pixel_px);
  const auto forward = ray ? camera_.project_jacobian(*ray) : std::nullopt;
  if (!forward) return std::nullopt;
  // Of the directions perpendicular to the ray, the inverse of the 2 x 2 derivative of the projection.
  const Eigen::Matrix<double, 3, 2> inverse =
      forward->transpose() * (*forward * forward->transpose()).inverse();
  if (!inverse.allFinite()) return std::nullopt;
  return inverse;
}

std::optional<Eigen::Vector2f> RayTable::undistorted_px(int u, int v) const {
  const Eigen::Vector3d* const known = pixel_ray(u, v);
  if (!known) return std::nullopt;
  const Eigen::Vector3d& ray = *known;
  if (!(ray.z() > min_cos_undistorted)) return std::nullopt;
  const double scale = camera_.focal_px() / ray.z();
  return Eigen::Vector2f(static_cast<float>(ray.x() * scale), static_cast<float>(ray.y() * scale));
}

}  // namespace ballservo
