// Stage 1: every pixel's colour class, by table look-up (paper, "Segmentation").
#pragma once

#include <opencv2/core.hpp>

#include "perception/segmentation/bit_picture.hpp"
#include "perception/segmentation/color_lookup.hpp"

namespace ballservo {

/// The pixels of each class in a picture of 8-bit BGR (CV_8UC3, rows anywhere in memory). `threads`
/// share the rows, with the same result; one takes no memory but for a larger picture. Throws InputError for
/// a picture of another type (grey has no colours to tell).
void classify(const cv::Mat& bgr, const ColorLookup& colors, ClassPictures& classes, int threads = 1);

/// Class numbers (CV_8UC1) for those who want to look at them; 0 where there is no class.
cv::Mat class_numbers(const ClassPictures& classes, cv::Size size);

}  // namespace ballservo
