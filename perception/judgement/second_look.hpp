// A second look at a supposed ball, at the colours of its pixels themselves: for those that outline and class
// leave in doubt, since it is slow.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/sphere_outline.hpp"
#include "calibration/circles/circle_evidence.hpp"
#include "perception/segmentation/bit_picture.hpp"
#include "perception/segmentation/color_lookup.hpp"

namespace ballservo {

class SecondLook {
 public:
  struct Look {
    CircleEvidence seen;  ///< its place in px of the picture
    double log_odds = 0;  ///< that it is a ball, of a known colour
  };

  /// In a dimmer light than the taught one, pixels are looked at as bright as that would have shown them:
  /// their contrast is judged by what it is in a picture of ordinary brightness.
  void set_light(const LightCells& light);

  /// How much noise pictures have (sigma, grey levels). Where it is much, a ball is looked at more coarsely.
  void set_noise(double sigma) { noise_sigma_ = sigma; }

  /// Odds of 0, no answer, where hardly any pixel inside the outline has the ball's colour or lies in the
  /// picture.
  Look look(const cv::Mat& bgr, const ColoredPixels& colored, const OutlineEllipse& outline);

 private:
  double brightening_ = 1;  // factor on grey levels
  double noise_sigma_ = 0;
  std::vector<cv::Vec3f> lab_;  // of the ball and what is around it
};

}  // namespace ballservo
