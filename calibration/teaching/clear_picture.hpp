// A picture as a better camera would have taken it: what the search for balls looks at.
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// The picture (CV_8UC3), raised where it is underexposed, since chroma shrinks with the light until it
/// cannot be told from grey, and smoothed where it is noisy, since a grey wall's noise has all colours.
/// Shares its pixels with `bgr` where nothing had to be done.
cv::Mat clear_picture(const cv::Mat& bgr);

/// The noise's standard deviation, from the median difference of neighbours (half a value at least).
double picture_noise(const cv::Mat& bgr);

}  // namespace ballservo
