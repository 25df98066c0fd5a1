// Pictures in which noise hides colours, made smoother.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ballservo {

class Smoothing {
 public:
  /// By 1 4 6 4 1 along rows and columns: noise of independent pixels is left with 0.27 of its sigma. BGR, 8
  /// bits, of any size; valid until the next call. Takes no memory but for a larger picture.
  const cv::Mat& smoothed(const cv::Mat& bgr);

 private:
  cv::Mat all_, smoothed_;              // of the largest picture so far, and its corner of this one's size
  std::vector<std::uint16_t> columns_;  // sums over five rows, and two pixels more at each end
};

}  // namespace ballservo
