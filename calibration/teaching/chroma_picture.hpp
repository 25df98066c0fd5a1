// A picture's chroma, blind to luminance (paper, "Calibrage", 2a).
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// (L, a, b) of every pixel of a CV_8UC3 picture in BGR.
cv::Mat3f lab_image(const cv::Mat& bgr);

/// (u*, v*) of every pixel, CV_32FC2, of a CV_8UC3 picture in BGR.
cv::Mat chroma_image(const cv::Mat& bgr);

/// The median of 5 x 5 pixels, in u* and in v*: takes the noise and keeps the edges.
cv::Mat smoothed_chroma(const cv::Mat& chroma);

}  // namespace ballservo
