#include "calibration/color/color_space.hpp"

#include <array>
#include <cmath>

namespace ballservo {
namespace {

std::array<double, 256> make_linear_table() {
  std::array<double, 256> table{};
  for (int i = 0; i < 256; ++i) table[i] = linear_from_srgb(i / 255.0);
  return table;
}

Eigen::Vector3d xyz_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r) {
  static const std::array<double, 256> linear = make_linear_table();
  return xyz_from_linear_rgb() * Eigen::Vector3d(linear[r], linear[g], linear[b]);
}

// White is what the matrix makes of (1, 1, 1), so that every grey has exactly no chroma (up to rounding).
const Eigen::Vector3d& white() {
  static const Eigen::Vector3d xyz = xyz_from_linear_rgb() * Eigen::Vector3d::Ones();
  return xyz;
}

}  // namespace

double lab_f(double t) {
  constexpr double epsilon = 216.0 / 24389.0, kappa = 24389.0 / 27.0;  // CIE 15:2004, the exact fractions
  return t > epsilon ? std::cbrt(t) : (kappa * t + 16.0) / 116.0;
}

const Eigen::Matrix3d& xyz_from_linear_rgb() {
  static const Eigen::Matrix3d matrix = (Eigen::Matrix3d() << 0.4124564, 0.3575761, 0.1804375,  //
                                         0.2126729, 0.7151522, 0.0721750,                       //
                                         0.0193339, 0.1191920, 0.9503041)
                                            .finished();
  return matrix;
}

double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

double srgb_from_linear(double v) {
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

Eigen::Vector3d lab_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r) {
  const Eigen::Vector3d ratio = xyz_from_bgr(b, g, r).cwiseQuotient(white());
  const double fx = lab_f(ratio.x()), fy = lab_f(ratio.y()), fz = lab_f(ratio.z());
  return {116.0 * fy - 16.0, 500.0 * (fx - fy), 200.0 * (fy - fz)};
}

FastLab::FastLab() {
  const Eigen::Matrix3d ratios = white().cwiseInverse().asDiagonal() * xyz_from_linear_rgb();
  for (std::size_t i = 0; i < 256; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      ratios_[c][i] = (steps * linear_from_srgb(static_cast<double>(i) / 255) *
                       ratios.col(2 - static_cast<Eigen::Index>(c)))
                          .cast<float>();
    }
  }
  for (std::size_t i = 0; i < f_.size(); ++i)
    f_[i] = static_cast<float>(lab_f(static_cast<double>(i) / steps));
}

Eigen::Vector3f FastLab::operator()(std::uint8_t b, std::uint8_t g, std::uint8_t r) const {
  const auto f = [this](float at) {
    const auto i = static_cast<std::size_t>(at);
    return f_[i] + (at - static_cast<float>(i)) * (f_[i + 1] - f_[i]);
  };
  const Eigen::Vector3f at = ratios_[0][b] + ratios_[1][g] + ratios_[2][r];
  const float x = f(at.x()), y = f(at.y()), z = f(at.z());
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

const FastLab& fast_lab() {
  static const FastLab table;
  return table;
}

Eigen::Vector3d luv_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r) {
  const Eigen::Vector3d xyz = xyz_from_bgr(b, g, r);
  const auto denominator = [](const Eigen::Vector3d& c) { return c.x() + 15.0 * c.y() + 3.0 * c.z(); };
  const double d = denominator(xyz), dn = denominator(white());
  if (d <= 0) return {0, 0, 0};
  const double lightness = 116.0 * lab_f(xyz.y() / white().y()) - 16.0;
  return {lightness, 13.0 * lightness * (4.0 * xyz.x() / d - 4.0 * white().x() / dn),
          13.0 * lightness * (9.0 * xyz.y() / d - 9.0 * white().y() / dn)};
}

}  // namespace ballservo
