#include "calibration/teaching/light_change.hpp"

#include <Eigen/LU>

#include "calibration/color/color_space.hpp"

namespace ballservo {
namespace {

/// XYZ of a Planckian radiator, Y = 1 (cubic splines of Kim et al., US patent 7024034, 2006).
Eigen::Vector3d planckian_white(double temperature_k) {
  const double i = 1e3 / temperature_k;
  const double x = temperature_k <= 4000 ? ((-0.2661239 * i - 0.2343589) * i + 0.8776956) * i + 0.179910
                                         : ((-3.0258469 * i + 2.1070379) * i + 0.2226347) * i + 0.240390;
  const double y = temperature_k <= 2222   ? ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683
                   : temperature_k <= 4000 ? ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867
                                           : ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483;
  return {x / y, 1, (1 - x - y) / y};
}

/// Bradford's cone responses (Lam, 1985).
Eigen::Matrix3d bradford() {
  return (Eigen::Matrix3d() << 0.8951, 0.2664, -0.1614,  //
          -0.7502, 1.7135, 0.0367,                       //
          0.0389, -0.0685, 1.0296)
      .finished();
}

}  // namespace

Eigen::Matrix3d light_change(double temperature_k) {
  const Eigen::Matrix3d cones = bradford(), xyz = xyz_from_linear_rgb();
  const Eigen::Vector3d gains =
      (cones * planckian_white(temperature_k)).cwiseQuotient(cones * planckian_white(taught_temperature_k));
  return (cones * xyz).inverse() * gains.asDiagonal() * (cones * xyz);
}

}  // namespace ballservo
