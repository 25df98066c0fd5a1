// sRGB (8 bits a channel, D65) to CIE Lab and CIE Luv.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace ballservo {

/// (L, a, b) of CIE Lab, L from 0 to 100.
Eigen::Vector3d lab_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r);

/// (L, u*, v*) of CIE Luv, L from 0 to 100.
Eigen::Vector3d luv_from_bgr(std::uint8_t b, std::uint8_t g, std::uint8_t r);

}  // namespace ballservo
