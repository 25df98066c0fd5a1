// What another light does to a colour, to first order: a factor, and von Kries' gains in a cone space.
#pragma once

#include <Eigen/Core>

namespace ballservo {

/// Linear sRGB of a thing under a Planckian light of `temperature_k` as a camera balanced for 6500 K sees it,
/// when it is `linear_rgb` under 6500 K: in Bradford's cone space each channel is scaled as the white is (von
/// Kries), the white's luminance kept. A real light has a spectrum, not a temperature: an estimate.
class LightTemperature {
 public:
  /// `temperature_k` from 1667 to 25000.
  explicit LightTemperature(double temperature_k);
  Eigen::Vector3d operator()(const Eigen::Vector3d& linear_rgb) const { return adapt_ * linear_rgb; }

 private:
  Eigen::Matrix3d adapt_;
};

inline constexpr double taught_temperature_k = 6500;

}  // namespace ballservo
