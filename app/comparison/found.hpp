// When a ball counts as found: the one definition of comparison, tests and benchmarks.
#pragma once

#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {

/// The answer's centre lies within this part of the true radius of the true centre, and its radius within
/// the same part of the true one.
inline constexpr double found_within = 0.2;

inline bool is_found(const OutlineEllipse& answer, const OutlineEllipse& truth) {
  const double allowed_px = found_within * truth.radius_px;
  return (answer.center_px - truth.center_px).norm() <= allowed_px &&
         std::abs(answer.radius_px - truth.radius_px) <= allowed_px;
}

}  // namespace ballservo
