#include "calibration/camera/ray_table.hpp"

#include <cstddef>
#include <limits>
#include <utility>

namespace ballservo {
namespace {

constexpr double min_cos_undistorted = 0.08715574274765817;  // 85 degrees

}  // namespace

std::vector<Eigen::Vector3d> rays_of_grid(const Camera& camera, const Eigen::Vector2d& first_px, int columns,
                                          int rows) {
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Eigen::Vector3d> rays;
  rays.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (int row = 0; row < rows; ++row) {
    Eigen::Vector3d before[3] = {none, none, none};  // the last one first
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d expected = 3 * (before[0] - before[1]) + before[2];  // as a parabola goes on
      const Eigen::Vector3d ray =
          camera.unproject(first_px + Eigen::Vector2d(column, row), expected).value_or(none);
      before[2] = std::exchange(before[1], std::exchange(before[0], ray));
      rays.push_back(ray);
    }
  }
  return rays;
}

RayTable::RayTable(const Camera& camera)
    : camera_(camera),
      stride_(camera.size().width_px + 2 * margin_px_),
      rows_(camera.size().height_px + 2 * margin_px_),
      rays_(rays_of_grid(camera, Eigen::Vector2d::Constant(-margin_px_), stride_, rows_)) {}

std::optional<Eigen::Vector2f> RayTable::undistorted_px(int u, int v) const {
  const Eigen::Vector3d* const ray = pixel_ray(u, v);
  if (!ray || !(ray->z() > min_cos_undistorted)) return std::nullopt;
  return (ray->head<2>() * (camera_.focal_px() / ray->z())).cast<float>();
}

}  // namespace ballservo
