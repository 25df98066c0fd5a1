#include "servo/simulation/rendering/lens_rays.hpp"

#include <limits>

#include "calibration/camera/ray_table.hpp"

namespace ballservo {

LensRays::LensRays(const Camera& camera)
    : width_(camera.size().width_px),
      height_(camera.size().height_px),
      groups_((width_ + lanes - 1) / lanes),
      pixel_rad_(1.0 / camera.focal_px()),
      centers_(static_cast<std::size_t>(groups_ * height_)) {
  const Eigen::Vector3f dark = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  for (const Eigen::Vector3d& ray :
       rays_of_grid(camera, Eigen::Vector2d::Constant(-0.5), width_ + 1, height_ + 1))
    corners_.push_back(ray.cast<float>());
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < lanes * groups_; ++column) {
      Eigen::Vector3f ray = dark;
      if (column < width_) {
        ray = ((corner(row, column) + corner(row, column + 1)) +
               (corner(row + 1, column) + corner(row + 1, column + 1)))
                  .normalized();
      }
      Triples& rays = centers_[static_cast<std::size_t>(row * groups_ + column / lanes)];
      rays.x[column % lanes] = ray.x();
      rays.y[column % lanes] = ray.y();
      rays.z[column % lanes] = ray.z();
    }
  }
  for (int row = 1; row <= height_; ++row) {
    for (int column = 0; column <= width_; ++column) {
      const Eigen::Vector3f& here = corner(row, column);
      const float along = column == 0 ? 0.0f : (here - corner(row, column - 1)).norm();
      for (const float step : {along, (here - corner(row - 1, column)).norm()}) {
        if (step > widest_pixel_rad_) widest_pixel_rad_ = step;  // never for NaN
      }
    }
  }
}

}  // namespace ballservo
