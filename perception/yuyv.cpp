#include "perception/yuyv.hpp"

#include <algorithm>

namespace ballservo {
namespace {

// Times 2^20: 255 / 219 for the level; 2 (1 - Kb) 255 / 224 and so on for the colours, with Kr = 0.299 and
// Kb = 0.114, as rounded by OpenCV.
constexpr int shift = 20, half = 1 << (shift - 1);
constexpr int level = 1220542, blue_of_u = 2116026, green_of_u = -409993, green_of_v = -852492,
              red_of_v = 1673527;

std::uint8_t byte(int value) { return static_cast<std::uint8_t>(std::clamp(value >> shift, 0, 255)); }

}  // namespace

void yuyv_to_bgr(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr) {
  for (int i = 0; i < pixels; i += 2, yuyv += 4, bgr += 6) {
    const int u = yuyv[1] - 128, v = yuyv[3] - 128;
    const int blue = half + blue_of_u * u, green = half + green_of_u * u + green_of_v * v,
              red = half + red_of_v * v;
    for (int k = 0; k < 2; ++k) {
      const int y = std::max(0, yuyv[2 * k] - 16) * level;
      bgr[3 * k] = byte(y + blue);
      bgr[3 * k + 1] = byte(y + green);
      bgr[3 * k + 2] = byte(y + red);
    }
  }
}

}  // namespace ballservo
