// A picture as a better camera would have taken it: what the search for balls looks at.
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// What a picture has to have before it is searched as it is. Values are those of its 8-bit channels.
struct ClearPictureOptions {
  double least_white = 153;  ///< of the brightest hundredth; darker pictures are raised to it, 0 to 255
  double most_gain = 4;      ///< but not by more: it would show noise alone; 1 or more
  double most_noise = 2.5;   ///< standard deviation; noisier pictures are smoothed; above 0

  /// Throws InputError with every value out of range.
  void validate() const;
};

/// The picture (CV_8UC3), raised where it is underexposed, since chroma shrinks with the light until it
/// cannot be told from grey, and smoothed where it is noisy, since a grey wall's noise has all colours.
/// Shares its pixels with `bgr` where nothing had to be done.
cv::Mat clear_picture(const cv::Mat& bgr, const ClearPictureOptions& options = {});

/// The noise's standard deviation, from the median difference of neighbours (half a value at least).
double picture_noise(const cv::Mat& bgr);

}  // namespace ballservo
