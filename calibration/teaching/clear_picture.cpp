#include "calibration/teaching/clear_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ballservo {
namespace {

// Of the 8-bit channels:
constexpr double least_white = 153;  // of the brightest hundredth; darker pictures are raised to it ...
constexpr double most_gain = 4;      // ... but not by more, which would show noise alone
constexpr double most_noise = 2.5;   // standard deviation; noisier pictures are smoothed

using ValueCounts = std::array<std::size_t, 256>;

/// The largest value that more than `above` of those counted reach.
int value_reached(const ValueCounts& counts, std::size_t above) {
  int value = 255;
  while (value > 0 && counts[value] <= above) above -= counts[value--];
  return value;
}

double gain_to_expose_well(const cv::Mat& bgr) {
  ValueCounts counts{};
  for (int y = 0; y < bgr.rows; ++y) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(y);
    for (int x = 0; x < bgr.cols; ++x) ++counts[std::max({row[x][0], row[x][1], row[x][2]})];
  }
  const int white = std::max(1, value_reached(counts, bgr.total() / 100));
  return std::clamp(least_white / white, 1.0, most_gain);
}

}  // namespace

double picture_noise(const cv::Mat& bgr) {
  ValueCounts counts{};
  std::size_t total = 0;
  for (int y = 0; y < bgr.rows; ++y) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(y);
    for (int x = 1; x < bgr.cols; ++x) {
      for (int k = 0; k < 3; ++k) ++counts[std::abs(row[x][k] - row[x - 1][k])];
    }
    total += 3 * static_cast<std::size_t>(std::max(0, bgr.cols - 1));
  }
  const double median = value_reached(counts, total / 2);
  return std::max(0.5, median / (0.6745 * std::sqrt(2.0)));  // the median of |N(0, 2 sigma^2)|
}

cv::Mat clear_picture(const cv::Mat& bgr) {
  cv::Mat smooth = bgr;
  const double noise = picture_noise(bgr);
  if (noise > most_noise) {
    constexpr double left_of_noise = 0.28;  // by a Gaussian one pixel wide: 1 / (2 sqrt(pi))
    constexpr double wanted_noise = 1.5;
    const double sigma_px = left_of_noise * noise / wanted_noise;
    smooth = cv::Mat();
    cv::GaussianBlur(bgr, smooth, {}, sigma_px, sigma_px, cv::BORDER_REPLICATE);
  }
  const double gain = gain_to_expose_well(smooth);
  if (gain <= 1) return smooth;
  cv::Mat exposed;
  smooth.convertTo(exposed, -1, gain);
  return exposed;
}

}  // namespace ballservo
