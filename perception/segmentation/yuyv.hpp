// The pixels that most cameras send. No OpenCV or Eigen here, as in classification_kernels.hpp.
#pragma once

#include <cstdint>

namespace ballservo {

/// BT.601 with levels from 16 (black) to 235, in fixed-point numbers times 2^20 as OpenCV has rounded them:
/// 255 / 219 for the level; 2 (1 - Kb) 255 / 224 and so on for the colours, with Kr = 0.299, Kb = 0.114.
struct YuvFactors {
  static constexpr int shift = 20, half = 1 << (shift - 1);
  static constexpr int level = 1220542, blue_of_u = 2116026, green_of_u = -409993, green_of_v = -852492,
                       red_of_v = 1673527;
};

/// BGR of an even number of pixels of YUYV (bytes Y0 U Y1 V): what OpenCV's COLOR_YUV2BGR_YUY2 gives, to the
/// bit. Writes up to `yuyv_slack` bytes behind the last pixel.
using YuyvKernel = void (*)(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr);
constexpr int yuyv_slack = 4;

void yuyv_to_bgr_portable(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr);
#if defined(__x86_64__)
void yuyv_to_bgr_avx2(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr);
#endif

}  // namespace ballservo
