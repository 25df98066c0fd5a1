// What the lens models share.
//
// A lens maps a ray of the camera frame to a *normalised position*: where it meets the picture, in focal
// lengths from the principal point. Each lens is a struct without data:
//   name, coefficient_names   as users see them
//   perspective               true: only rays with Z > 0 appear
//   distort(k, ray)           ray (any length) to normalised position; NaN where the ray does not appear
//   undistort(k, m)           only in lenses that are defined from the picture to the ray: the ray (X, Y, 1)
// for double, Dual and ceres::Jet. `k` points to the coefficients.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

namespace ballservo {

template <class T>
struct Position2 {
  T x, y;
};

template <class T>
struct Ray3 {
  T x, y, z;
};

/// Whether a lens is defined from the picture to the ray (it then has `undistort`).
template <class Lens, class = void>
struct IsDefinedFromPixel : std::false_type {};
template <class Lens>
struct IsDefinedFromPixel<Lens, std::void_t<decltype(Lens::template undistort<double>(nullptr, {}))>>
    : std::true_type {};

}  // namespace ballservo
