// How much noise a picture has.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace ballservo {

/// How often Immerkaer's Laplacian (Computer Vision and Image Understanding 64(2), 1996) has each size:
/// slopes do not show in it, and noise has 36 times its variance.
class LaplacianHistogram {
 public:
  void add(int laplacian);
  int seen() const { return seen_; }
  /// Grey levels^2; by the smallest quarter: most of a texture lies above. Of none seen: 0.
  double noise_variance() const;

 private:
  static constexpr int largest = 255;
  std::array<int, largest + 1> counts_{};
  int seen_ = 0;
};

/// The standard deviation (grey levels) of the noise of a picture's green, by about a thousand of its pixels.
/// BGR, 8 bits.
double noise_sigma(const cv::Mat& bgr);

}  // namespace ballservo
