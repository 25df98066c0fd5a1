#include "servo/simulation/rendering/lens_rays.hpp"

#include <tbb/parallel_for.h>

#include <limits>

namespace ballservo {

LensRays::LensRays(const Camera& camera)
    : width_(camera.size().width_px),
      height_(camera.size().height_px),
      groups_((width_ + lanes - 1) / lanes),
      pixel_rad_(1.0 / camera.focal_px()),
      corners_(static_cast<std::size_t>((width_ + 1) * (height_ + 1))),
      centers_(static_cast<std::size_t>(groups_ * height_)) {
  const Eigen::Vector3f dark = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  tbb::parallel_for(0, height_ + 1, [&](int row) {
    for (int column = 0; column <= width_; ++column) {
      const auto ray = camera.unproject({column - 0.5, row - 0.5});
      corners_[static_cast<std::size_t>(row * (width_ + 1) + column)] =
          ray ? ray->cast<float>().eval() : dark;
    }
  });
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
