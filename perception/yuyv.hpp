// The pixels that most cameras send.
#pragma once

#include <cstdint>

namespace ballservo {

/// BGR of an even number of pixels of YUYV (bytes Y0 U Y1 V), by ITU-R BT.601 with levels from 16 (black) to
/// 235, in the fixed-point numbers of OpenCV's COLOR_YUV2BGR_YUY2: the same to the bit.
void yuyv_to_bgr(const std::uint8_t* yuyv, int pixels, std::uint8_t* bgr);

}  // namespace ballservo
