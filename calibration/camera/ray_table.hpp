// The ray of every pixel, computed once (paper, "Calibrage": the look-up table of undistorted positions).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// The unit rays of positions a pixel apart, from `first_px` on row by row; NaN where no ray reaches one.
std::vector<Eigen::Vector3d> rays_of_grid(const Camera& camera, const Eigen::Vector2d& first_px, int columns,
                                          int rows);

/// Unit rays on the pixel grid, with a margin of a few pixels around the picture. Immutable after
/// construction; look-ups allocate nothing.
class RayTable {
 public:
  explicit RayTable(const Camera& camera);

  const Camera& camera() const { return camera_; }
  ImageSize size() const { return camera_.size(); }

  /// The unit ray of an integer pixel, straight from the table; null outside it or where no ray reaches the
  /// pixel.
  const Eigen::Vector3d* pixel_ray(int u, int v) const {
    const int column = u + margin_px_, row = v + margin_px_;
    if (column < 0 || column >= stride_ || row < 0 || row >= rows_) return nullptr;
    const Eigen::Vector3d& ray = rays_[static_cast<std::size_t>(row) * static_cast<std::size_t>(stride_) +
                                       static_cast<std::size_t>(column)];
    return ray.x() == ray.x() ? &ray : nullptr;
  }

  /// The rays of a row's pixels will be looked up soon: a table as large as this is out of the caches. Any
  /// pixels within the picture.
  void prefetch(int first_u, int last_u, int v) const {
    constexpr int rays_per_line = 2;
    const Eigen::Vector3d* const row =
        rays_.data() + static_cast<std::ptrdiff_t>(v + margin_px_) * stride_ + margin_px_;
    for (int u = first_u; u <= last_u; u += rays_per_line) __builtin_prefetch(row + u);
  }

  /// The position of an integer pixel in the undistorted picture of square pixels, relative to its principal
  /// point: focal_px * (X/Z, Y/Z) of its ray (px). Nothing for rays of more than 85 degrees from the axis.
  std::optional<Eigen::Vector2f> undistorted_px(int u, int v) const;

 private:
  static constexpr int margin_px_ = 6;  // outlines may reach a little beyond the picture

  Camera camera_;
  int stride_ = 0, rows_ = 0;
  std::vector<Eigen::Vector3d> rays_;  // row by row, margin included; NaN where no ray reaches
};

}  // namespace ballservo
