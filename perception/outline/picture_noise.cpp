#include "perception/outline/picture_noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace ballservo {

void LaplacianHistogram::add(int laplacian) {
  ++counts_[static_cast<std::size_t>(std::min(std::abs(laplacian), largest))];
  ++seen_;
}

double LaplacianHistogram::noise_variance() const {
  constexpr double quarter_of_normal = 0.31864;  // |x| of a standard normal is below in one of four
  if (seen_ == 0) return 0;
  const double wanted = 0.25 * seen_;
  std::size_t size = 0;
  int below = 0;
  while (below + counts_[size] < wanted) below += counts_[size++];
  // Whole numbers stand for half a step to either side, 0 for half a step.
  const double share = (wanted - below) / counts_[size];
  const double quantile = size == 0 ? 0.5 * share : static_cast<double>(size) - 0.5 + share;
  return std::pow(quantile / quarter_of_normal, 2) / 36;
}

double noise_sigma(const cv::Mat& bgr) {
  constexpr double looked_at_px = 1000;
  constexpr int green = 1;
  CV_Assert(bgr.type() == CV_8UC3);
  LaplacianHistogram seen;
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(bgr.total()) / looked_at_px)));
  for (int v = 1; v < bgr.rows - 1; v += step) {
    const cv::Vec3b *above = bgr.ptr<cv::Vec3b>(v - 1), *here = bgr.ptr<cv::Vec3b>(v),
                    *below = bgr.ptr<cv::Vec3b>(v + 1);
    const auto across = [](const cv::Vec3b* row, int u) {
      return row[u - 1][green] - 2 * row[u][green] + row[u + 1][green];
    };
    for (int u = 1; u < bgr.cols - 1; u += step)
      seen.add(across(above, u) - 2 * across(here, u) + across(below, u));
  }
  return std::sqrt(seen.noise_variance());
}

}  // namespace ballservo
