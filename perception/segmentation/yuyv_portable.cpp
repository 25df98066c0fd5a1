#include <algorithm>

#include "perception/segmentation/yuyv.hpp"

namespace ballservo {
namespace {

using F = YuvFactors;

std::uint8_t byte(int value) { return static_cast<std::uint8_t>(std::clamp(value >> F::shift, 0, 255)); }

}  // namespace

void yuyv_to_bgr_portable(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr) {
  for (int i = 0; i < pixels; i += 2, yuyv += 4, bgr += 6) {
    const int u = yuyv[1] - 128, v = yuyv[3] - 128;
    const int blue = F::half + F::blue_of_u * u, green = F::half + F::green_of_u * u + F::green_of_v * v,
              red = F::half + F::red_of_v * v;
    for (int k = 0; k < 2; ++k) {
      const int y = std::max(0, yuyv[2 * k] - 16) * F::level;
      bgr[3 * k] = byte(y + blue);
      bgr[3 * k + 1] = byte(y + green);
      bgr[3 * k + 2] = byte(y + red);
    }
  }
}

}  // namespace ballservo
