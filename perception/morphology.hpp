// Stage 2: noise removal and hole filling on the class picture (paper, figures 2c and 4).
#pragma once

#include <opencv2/core.hpp>

namespace ballservo {

/// Opening (3x3) of every class on its own: specks thinner than three pixels go. CV_8UC1 in and out.
class ClassMorphology {
 public:
  void open(const cv::Mat& classes, cv::Mat& opened, int class_count);
  /// Closing (5x5) of every class on its own; a pixel that already has a class keeps it.
  void close(const cv::Mat& opened, cv::Mat& closed, int class_count);

 private:
  cv::Mat mask_, result_;  // reused between frames
};

}  // namespace ballservo
