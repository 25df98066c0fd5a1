// The on-line circle estimator as colour calibration asks for it.
#pragma once

#include <cstdint>

#include "calibration/circles/circle_test.hpp"

namespace ballservo {

/// A deterministic CircleEstimator by votes: every call draws from a stream of `seed` and the region's size.
CircleEstimator region_circle_estimator(std::uint64_t seed);

}  // namespace ballservo
