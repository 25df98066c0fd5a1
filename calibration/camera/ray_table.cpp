#include "calibration/camera/ray_table.hpp"

#include <cstddef>
#include <limits>

namespace ballservo {
namespace {

// Outlines may reach a little beyond the picture.
constexpr int table_margin_px = 6;
constexpr double min_cos_undistorted = 0.08715574274765817;  // 85 degrees

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

std::optional<Eigen::Vector2f> RayTable::undistorted_px(int u, int v) const {
  const Eigen::Vector3d* const known = pixel_ray(u, v);
  if (!known) return std::nullopt;
  const Eigen::Vector3d& ray = *known;
  if (!(ray.z() > min_cos_undistorted)) return std::nullopt;
  const double scale = camera_.focal_px() / ray.z();
  return Eigen::Vector2f(static_cast<float>(ray.x() * scale), static_cast<float>(ray.y() * scale));
}

}  // namespace ballservo
