#include "calibration/teaching/chroma_picture.hpp"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/color/color_space.hpp"

namespace ballservo {
namespace {

/// lab_from_bgr to within a thousandth, for every pixel of a picture: the cube root is looked up.
class FastLab {
 public:
  FastLab() {
    const Eigen::Matrix3d& xyz = xyz_from_linear_rgb();
    const Eigen::Matrix3d ratios = xyz.rowwise().sum().asDiagonal().inverse() * xyz;
    for (int i = 0; i < 256; ++i) {
      for (int channel = 0; channel < 3; ++channel)  // of blue, green, red
        ratios_[channel][i] = (steps * linear_from_srgb(i / 255.0) * ratios.col(2 - channel)).cast<float>();
    }
    for (int i = 0; i < steps + 2; ++i) f_[i] = static_cast<float>(lab_f(i / double{steps}));
  }
  cv::Vec3f operator()(const cv::Vec3b& c) const {
    const Eigen::Vector3f at = ratios_[0][c[0]] + ratios_[1][c[1]] + ratios_[2][c[2]];
    const float x = f(at.x()), y = f(at.y()), z = f(at.z());
    return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
  }

 private:
  static constexpr int steps = 4096;
  float f(float at) const {
    const int i = static_cast<int>(at);
    return f_[i] + (at - static_cast<float>(i)) * (f_[i + 1] - f_[i]);
  }
  std::array<std::array<Eigen::Vector3f, 256>, 3> ratios_;
  std::array<float, steps + 2> f_{};
};

}  // namespace

cv::Mat3f lab_image(const cv::Mat& bgr) {
  static const FastLab fast_lab;
  cv::Mat3f result(bgr.size());
  std::transform(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), result.begin(),
                 [](const cv::Vec3b& c) { return fast_lab(c); });
  return result;
}

cv::Mat chroma_image(const cv::Mat& bgr) {
  cv::Mat result(bgr.size(), CV_32FC2);
  std::transform(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), result.begin<cv::Vec2f>(),
                 [](const cv::Vec3b& c) {
                   const Eigen::Vector3f luv = luv_from_bgr(c[0], c[1], c[2]).cast<float>();
                   return cv::Vec2f(luv[1], luv[2]);
                 });
  return result;
}

cv::Mat smoothed_chroma(const cv::Mat& chroma) {
  constexpr int side_px = 5;
  std::vector<cv::Mat> planes;
  cv::split(chroma, planes);
  for (cv::Mat& plane : planes) cv::medianBlur(plane, plane, side_px);
  cv::Mat result;
  cv::merge(planes, result);
  return result;
}

}  // namespace ballservo
