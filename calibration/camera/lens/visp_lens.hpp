// ViSP's "perspective projection with distortion", vpPixelMeterConversion: defined from the picture to the
// ray, X/Z = m_x (1 + kdu |m|^2).
//
// ViSP's other coefficient, kud, is a second model of its own for the other direction; a round trip through
// both errs by pixels. Here the other direction is the solution of this one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "calibration/camera/dual.hpp"
#include "calibration/camera/lens/lens_types.hpp"

namespace ballservo {

struct VispLens {
  static constexpr std::string_view name = "visp";
  static constexpr std::array<std::string_view, 1> coefficient_names{"kdu"};
  static constexpr bool perspective = true;

  template <class T>
  static Ray3<T> undistort(const T* k, const Position2<T>& m) {
    const T scale = 1.0 + k[0] * (m.x * m.x + m.y * m.y);
    return {m.x * scale, m.y * scale, T(1.0)};
  }

  /// m = s (X, Y)/Z with s + c s^3 = 1, c = kdu (X^2 + Y^2)/Z^2.
  template <class T>
  static Position2<T> distort(const T* k, const Ray3<T>& ray) {
    const T x = ray.x / ray.z, y = ray.y / ray.z;
    const T c = k[0] * (x * x + y * y);
    const double root = shrinkage(scalar_part(c));
    // One more Newton step from the solution changes nothing but carries the derivatives.
    const T s = root - (root + c * (root * root * root) - 1.0) / (1.0 + c * (3.0 * root * root));
    return {x * s, y * s};
  }

 private:
  /// The root of s + c s^3 = 1 that is 1 for c = 0; NaN below c = -4/27, where the lens has folded.
  static double shrinkage(double c) {
    if (!(c > -4.0 / 27.0) || !std::isfinite(c)) return std::numeric_limits<double>::quiet_NaN();
    // On these sides of the root the function is convex (c > 0) or concave (c < 0): Newton's steps approach
    // it from one side only.
    double s = c > 1 ? 1 / std::cbrt(c) : 1;
    for (int i = 0; i < 60; ++i) {
      const double step = (s * (1 + c * s * s) - 1) / (1 + 3 * c * s * s);
      s -= step;
      if (!(std::abs(step) > 1e-16 * s)) break;
    }
    return std::clamp(s, 0.0, 1.5);
  }
};

}  // namespace ballservo
