// Stage 1: every pixel's colour class, by table look-up (paper, "Segmentation").
#pragma once

#include <opencv2/core.hpp>

#include "perception/segmentation/bit_picture.hpp"
#include "perception/segmentation/color_lookup.hpp"

namespace ballservo {

/// The instructions that the classification uses; all give the same pictures. `fastest` is the best that this
/// processor has.
enum class ClassificationKernel { fastest, portable, avx2, avx512 };

/// Whether this processor has the instructions.
bool runs_here(ClassificationKernel kernel);

/// The pixels of each class in a picture of 8-bit BGR (CV_8UC3, rows anywhere in memory). `threads`
/// share the rows, with the same result; one takes no memory but for a larger picture. Throws InputError for
/// a picture of another type (grey has no colours to tell) and for a kernel that does not run here.
void classify(const cv::Mat& bgr, const ColorLookup& colors, ClassPictures& classes,
              ClassificationKernel kernel = ClassificationKernel::fastest, int threads = 1);

/// Class numbers (CV_8UC1) for those who want to look at them; 0 where there is no class.
cv::Mat class_numbers(const ClassPictures& classes, cv::Size size);

}  // namespace ballservo
