// Stage 1: every pixel's colour class, by table look-up (paper, "Segmentation").
#pragma once

#include <opencv2/core.hpp>

#include "calibration/color/color_table.hpp"

namespace ballservo {

/// Class of every pixel of an 8-bit BGR picture (CV_8UC3) into `classes` (CV_8UC1, reallocated only if its
/// size differs).
void classify(const cv::Mat& bgr, const ColorTable& table, cv::Mat& classes);

}  // namespace ballservo
