// Kannala-Brandt: the distance from the principal point is an odd polynomial of the angle from the axis
// (Kannala and Brandt, PAMI 2006, as OpenCV's fisheye, ROS' equidistant and ViSP have it).
#pragma once

#include <array>
#include <string_view>

#include "calibration/camera/dual.hpp"
#include "calibration/camera/lens/lens_types.hpp"

namespace ballservo {

struct KannalaBrandtLens {
  static constexpr std::string_view name = "kannala_brandt";
  static constexpr std::array<std::string_view, 4> coefficient_names{"k1", "k2", "k3", "k4"};
  static constexpr bool perspective = false;

  template <class T>
  static Position2<T> distort(const T* k, const Ray3<T>& ray) {
    using std::atan2;
    using std::sqrt;
    const T r2 = ray.x * ray.x + ray.y * ray.y;
    // On the axis itself the square root has no derivative, and the lens is a pinhole to machine precision.
    if (scalar_part(ray.z) > 0 && scalar_part(r2) < 1e-18 * scalar_part(ray.z * ray.z))
      return {ray.x / ray.z, ray.y / ray.z};
    const T r = sqrt(r2);
    const T theta = atan2(r, ray.z);
    const T t2 = theta * theta;
    const T scale = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r;
    return {ray.x * scale, ray.y * scale};
  }
};

}  // namespace ballservo
