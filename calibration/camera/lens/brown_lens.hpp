// Brown-Conrady with 5 coefficients (ROS plumb_bob) and 8 (ROS rational_polynomial), as OpenCV's
// projectPoints has them: D. C. Brown, "Close-range camera calibration", 1971.
#pragma once

#include <array>
#include <string_view>

#include "calibration/camera/lens/lens_types.hpp"

namespace ballservo {

/// Radial factor and tangential shift of a point of the normalised plane.
template <class T>
Position2<T> brown_distortion(const T& x, const T& y, const T& r2, const T& radial, const T& p1,
                              const T& p2) {
  const T xy2 = 2.0 * x * y;
  return {x * radial + p1 * xy2 + p2 * (r2 + 2.0 * x * x), y * radial + p1 * (r2 + 2.0 * y * y) + p2 * xy2};
}

struct BrownLens {
  static constexpr std::string_view name = "brown";
  static constexpr std::array<std::string_view, 5> coefficient_names{"k1", "k2", "p1", "p2", "k3"};
  static constexpr bool perspective = true;

  template <class T>
  static Position2<T> distort(const T* k, const Ray3<T>& ray) {
    const T x = ray.x / ray.z, y = ray.y / ray.z;
    const T r2 = x * x + y * y;
    const T radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    return brown_distortion(x, y, r2, radial, k[2], k[3]);
  }
};

struct Brown8Lens {
  static constexpr std::string_view name = "brown8";
  static constexpr std::array<std::string_view, 8> coefficient_names{"k1", "k2", "p1", "p2",
                                                                     "k3", "k4", "k5", "k6"};
  static constexpr bool perspective = true;

  template <class T>
  static Position2<T> distort(const T* k, const Ray3<T>& ray) {
    const T x = ray.x / ray.z, y = ray.y / ray.z;
    const T r2 = x * x + y * y;
    const T radial =
        (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    return brown_distortion(x, y, r2, radial, k[2], k[3]);
  }
};

}  // namespace ballservo
