// The lens without distortion.
#pragma once

#include <array>
#include <string_view>

#include "calibration/camera/lens/lens_types.hpp"

namespace ballservo {

struct PinholeLens {
  static constexpr std::string_view name = "pinhole";
  static constexpr std::array<std::string_view, 0> coefficient_names{};
  static constexpr bool perspective = true;

  template <class T>
  static Position2<T> distort(const T*, const Ray3<T>& ray) {
    return {ray.x / ray.z, ray.y / ray.z};
  }
};

}  // namespace ballservo
