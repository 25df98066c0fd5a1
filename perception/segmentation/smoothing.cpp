#include "perception/segmentation/smoothing.hpp"

#include <algorithm>

namespace ballservo {

const cv::Mat& Smoothing::smoothed(const cv::Mat& bgr) {
  constexpr std::size_t pixel = 3, ends = 2 * pixel;
  CV_Assert(bgr.type() == CV_8UC3);
  if (all_.rows < bgr.rows || all_.cols < bgr.cols)
    all_.create(std::max(all_.rows, bgr.rows), std::max(all_.cols, bgr.cols), CV_8UC3);
  smoothed_ = all_({{0, 0}, bgr.size()});
  const std::size_t bytes = pixel * static_cast<std::size_t>(bgr.cols);
  columns_.resize(bytes + 2 * ends);
  for (int v = 0; v < bgr.rows; ++v) {
    const auto row = [&](int down) { return bgr.ptr<std::uint8_t>(std::clamp(v + down, 0, bgr.rows - 1)); };
    const std::uint8_t *a = row(-2), *b = row(-1), *c = row(0), *d = row(1), *e = row(2);
    std::uint16_t* const sums = columns_.data() + ends;
    for (std::size_t i = 0; i < bytes; ++i)
      sums[i] = static_cast<std::uint16_t>(a[i] + 4 * (b[i] + d[i]) + 6 * c[i] + e[i]);
    for (std::size_t i = 0; i < ends; ++i) {
      columns_[i] = sums[i % pixel];
      sums[bytes + i] = sums[bytes - pixel + i % pixel];
    }
    std::uint8_t* const to = smoothed_.ptr<std::uint8_t>(v);
    const std::uint16_t* from = columns_.data();
    for (std::size_t i = 0; i < bytes; ++i)
      to[i] = static_cast<std::uint8_t>(
          (from[i] + 4 * (from[i + 3] + from[i + 9]) + 6 * from[i + 6] + from[i + 12] + 128) >> 8);
  }
  return smoothed_;
}

}  // namespace ballservo
