// What another light does to a colour, to first order: a factor, and von Kries' gains in a cone space.
#pragma once

#include <Eigen/Core>

namespace ballservo {

inline constexpr double taught_temperature_k = 6500;

/// To linear sRGB of a thing under a Planckian light of `temperature_k` (1667 to 25000) as a camera balanced
/// for 6500 K sees it, from what it is under 6500 K: in Bradford's cone space each channel is scaled as the
/// white is (von Kries), the white's luminance kept. A real light has a spectrum, not a temperature: an
/// estimate.
Eigen::Matrix3d light_change(double temperature_k);

}  // namespace ballservo
