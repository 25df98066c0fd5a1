// The lens models: each a struct without data, which maps a ray of the camera frame to a *normalised
// position* (where it meets the picture, in focal lengths from the principal point).
//   name, coefficient_names   as users see them
//   perspective               true: only rays with Z > 0 appear
//   distort(k, ray)           ray (any length) to normalised position; NaN where the ray does not appear
//   undistort(k, m)           only in lenses that are defined from the picture to the ray: the ray (X, Y, 1)
// for double, Dual and ceres::Jet. `k` points to the coefficients. A new one is a struct here, a name in
// LensModel and an entry of LensList.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "calibration/camera/camera.hpp"
#include "calibration/camera/dual.hpp"

namespace ballservo {

template <class T>
struct Position2 {
  T x, y;
};

template <class T>
struct Ray3 {
  T x, y, z;
};

/// Without distortion.
struct PinholeLens {
  static constexpr std::string_view name = "pinhole";
  static constexpr std::array<std::string_view, 0> coefficient_names{};
  static constexpr bool perspective = true;

  template <class T>
  static Position2<T> distort(const T*, const Ray3<T>& ray) {
    return {ray.x / ray.z, ray.y / ray.z};
  }
};

/// ViSP's "perspective projection with distortion", vpPixelMeterConversion: defined from the picture to the
/// ray, X/Z = m_x (1 + kdu |m|^2). ViSP's other coefficient, kud, is a second model of its own for the other
/// direction; a round trip through both errs by pixels. Here the other direction is the solution of this one.
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

/// Brown-Conrady with 5 coefficients (ROS plumb_bob) or 8 (ROS rational_polynomial), as OpenCV's
/// projectPoints has them: D. C. Brown, "Close-range camera calibration", 1971.
template <std::size_t count>
struct BrownLens {
  static constexpr std::string_view name = count == 8 ? "brown8" : "brown";
  static constexpr std::array<std::string_view, count> coefficient_names = [] {
    constexpr std::string_view all[]{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
    std::array<std::string_view, count> names{};
    for (std::size_t i = 0; i < count; ++i) names[i] = all[i];
    return names;
  }();
  static constexpr bool perspective = true;

  template <class T>
  static Position2<T> distort(const T* k, const Ray3<T>& ray) {
    const T x = ray.x / ray.z, y = ray.y / ray.z;
    const T r2 = x * x + y * y, xy2 = 2.0 * x * y;
    T radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
    if constexpr (count == 8) radial = radial / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
    return {x * radial + k[2] * xy2 + k[3] * (r2 + 2.0 * x * x),
            y * radial + k[2] * (r2 + 2.0 * y * y) + k[3] * xy2};
  }
};

/// The distance from the principal point is an odd polynomial of the angle from the axis (Kannala and Brandt,
/// PAMI 2006, as OpenCV's fisheye, ROS' equidistant and ViSP have it).
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

/// Whether a lens is defined from the picture to the ray (it then has `undistort`).
template <class Lens, class = void>
struct IsDefinedFromPixel : std::false_type {};
template <class Lens>
struct IsDefinedFromPixel<Lens, std::void_t<decltype(Lens::template undistort<double>(nullptr, {}))>>
    : std::true_type {};

/// In the order of LensModel.
using LensList = std::tuple<PinholeLens, VispLens, BrownLens<5>, BrownLens<8>, KannalaBrandtLens>;
static_assert(std::tuple_size_v<LensList> == all_lens_models.size());

template <class Lens>
inline constexpr int lens_coefficient_count = static_cast<int>(Lens::coefficient_names.size());

/// The coefficients as constants of another type; one more, so that a lens without any has an array too.
template <class Lens, class T>
std::array<T, lens_coefficient_count<Lens> + 1> lens_constants(const double* coefficients) {
  std::array<T, lens_coefficient_count<Lens> + 1> k;
  std::copy_n(coefficients, lens_coefficient_count<Lens>, k.begin());
  k.back() = T(0.0);
  return k;
}

/// Calls `visit` with the lens struct of a model.
template <class Visitor, std::size_t index = 0>
decltype(auto) with_lens(LensModel model, Visitor&& visit) {
  if constexpr (index + 1 < std::tuple_size_v<LensList>) {
    if (static_cast<std::size_t>(model) != index)
      return with_lens<Visitor, index + 1>(model, std::forward<Visitor>(visit));
  }
  return visit(std::tuple_element_t<index, LensList>{});
}

}  // namespace ballservo
