// A second look at a supposed ball, at the colours of its pixels themselves: for those that outline and class
// leave in doubt, since it is slow.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

class SecondLook {
 public:
  /// The logarithm of the odds that it is a ball (see CircleEvidence). 0, no answer, where hardly any pixel
  /// inside the outline has the ball's colour or lies in the picture.
  double log_odds(const cv::Mat& bgr, const ColoredPixels& colored, const OutlineEllipse& outline);

 private:
  std::vector<cv::Vec3f> lab_;  // of the ball and what is around it
};

}  // namespace ballservo
