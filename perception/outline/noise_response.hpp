// What a picture's noise says of its camera's response.
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// ln of the odds of sRGB against grey levels that are proportional to the light. A sensor's noise has the
/// variance a + b light (Foi, Trimeche, Katkovnik and Egiazarian 2008, eq. 3): in grey levels it grows with
/// the level where they are proportional, and falls where they are sRGB. 0 where it does neither, as in a
/// picture that was filtered, or where a texture hides it. BGR, 8 bits.
double srgb_log_odds_by_noise(const cv::Mat& bgr);

}  // namespace ballservo
