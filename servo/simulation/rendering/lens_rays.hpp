// The ray of every pixel of a lens, worked out once.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "servo/simulation/world/lanes.hpp"

namespace ballservo {

class LensRays {
 public:
  explicit LensRays(const Camera& camera);

  int width_px() const { return width_; }
  int height_px() const { return height_; }
  /// The angle that a pixel spans in the middle.
  double pixel_rad() const { return pixel_rad_; }
  /// The largest angle between neighbouring corners.
  double widest_pixel_rad() const { return widest_pixel_rad_; }

  /// The unit ray (camera frame) of the upper left corner of a pixel; one row and column more than there are
  /// pixels. NaN: no ray.
  const Eigen::Vector3f& corner(int row, int column) const {
    return corners_[static_cast<std::size_t>(row * (width_ + 1) + column)];
  }
  /// The unit rays of the centres of the pixels from `column`, a multiple of `lanes`, on; NaN beyond the row.
  const Triples& centers(int row, int column) const {
    return centers_[static_cast<std::size_t>(row * groups_ + column / lanes)];
  }

 private:
  int width_, height_, groups_;
  double pixel_rad_, widest_pixel_rad_ = 0;
  std::vector<Eigen::Vector3f> corners_;
  std::vector<Triples> centers_;
};

}  // namespace ballservo
