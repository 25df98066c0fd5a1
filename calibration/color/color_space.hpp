// sRGB (8 bits a channel, D65) to CIE Lab and CIE Luv.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace ballservo {

/// X, Y, Z of linear sRGB: its primaries with the D65 white point (IEC 61966-2-1), one row each.
const Eigen::Matrix3d& xyz_from_linear_rgb();

/// sRGB's transfer function and its inverse (IEC 61966-2-1), 0 to 1.
double linear_from_srgb(double value);
double srgb_from_linear(double value);

/// The function of CIE Lab: of X / Xn, Y / Yn, Z / Zn.
double lab_f(double ratio);

/// (L, a, b) of CIE Lab, L from 0 to 100.
Eigen::Vector3d lab_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r);

/// The same to within 1e-4, for many pixels: the cube root is looked up.
class FastLab {
 public:
  FastLab();
  Eigen::Vector3f operator()(std::uint8_t b, std::uint8_t g, std::uint8_t r) const;

 private:
  static constexpr int steps = 32768;
  std::array<std::array<Eigen::Vector3f, 256>, 3>
      ratios_;  // X / Xn, Y / Yn, Z / Zn of blue, green, red; steps
  std::array<float, steps + 2> f_{};
};
const FastLab& fast_lab();

/// (L, u*, v*) of CIE Luv, L from 0 to 100.
Eigen::Vector3d luv_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r);

}  // namespace ballservo
