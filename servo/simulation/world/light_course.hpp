// Light that changes: colour temperature and level over time.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "servo/simulation/world/texture.hpp"

namespace ballservo {

inline constexpr double min_temperature_k = 1667, max_temperature_k = 25000;

/// What a camera of sRGB's primaries sees of a black body of that temperature (K, from min_temperature_k to
/// max_temperature_k), linear and of luminance 1; a channel outside the gamut is 0. The chromaticity is the
/// cubic approximation of the Planckian locus by Kang, Moon, Hong, Lee, Cho and Kim, Journal of the Korean
/// Physical Society 41(6), 2002, pages 865-871; the primaries are those of IEC 61966-2-1.
Rgb planckian_rgb(double temperature_k);

/// A light at one moment.
struct LightKey {
  double time_s = 0;
  double temperature_k = 6500;
  double level = 1;  ///< factor on its intensity
};

/// How a light changes: linearly in temperature and level from one key to the next, at once where two keys
/// share a time; as the first key before it and as the last one after it.
struct LightCourse {
  double white_balance_k = 6500;  ///< the temperature that the camera shows as white
  std::vector<LightKey> keys;     ///< in order of time; none: the light never changes

  /// Factors on the light's intensity at a time: (1, 1, 1) at the white balance's temperature and level 1.
  Rgb gain(double time_s) const;
};

}  // namespace ballservo
