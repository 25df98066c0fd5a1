#include "perception/segmentation/smoothing.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace ballservo {
namespace {

cv::Mat noise(cv::Size size) {
  cv::Mat bgr(size, CV_8UC3);
  cv::RNG(1).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  return bgr;
}

/// The same by OpenCV, in floating point.
cv::Mat by_opencv(const cv::Mat& bgr) {
  const cv::Mat kernel = (cv::Mat1d(1, 5) << 1, 4, 6, 4, 1) / 16;
  cv::Mat sums, result;
  cv::sepFilter2D(bgr, sums, CV_64F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REPLICATE);
  cv::Mat(sums + cv::Scalar::all(1e-9)).convertTo(result, CV_8U);  // halves are rounded up
  return result;
}

TEST(Smoothing, IsTheBinomialFilterOfPicturesOfAnySize) {
  Smoothing smoothing;
  for (const cv::Size size :
       {cv::Size(320, 240), cv::Size(7, 3), cv::Size(1, 1), cv::Size(2, 400), cv::Size(641, 5)}) {
    const cv::Mat bgr = noise(size);
    const cv::Mat& smoothed = smoothing.smoothed(bgr);
    ASSERT_EQ(smoothed.size(), size);
    EXPECT_EQ(cv::norm(smoothed, by_opencv(bgr), cv::NORM_INF), 0) << size;
  }
}

TEST(Smoothing, ReadsNothingBesideAWindow) {
  const cv::Mat bgr = noise({100, 80});
  const cv::Mat window = bgr(cv::Rect(10, 20, 31, 17));
  Smoothing one, other;
  EXPECT_EQ(cv::norm(one.smoothed(window), other.smoothed(window.clone()), cv::NORM_INF), 0);
}

}  // namespace
}  // namespace ballservo
