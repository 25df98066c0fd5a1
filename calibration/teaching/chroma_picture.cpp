#include "calibration/teaching/chroma_picture.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "calibration/color/color_space.hpp"

namespace ballservo {
cv::Mat3f lab_image(const cv::Mat& bgr) {
  cv::Mat3f result(bgr.size());
  std::transform(bgr.begin<cv::Vec3b>(), bgr.end<cv::Vec3b>(), result.begin(),
                 [&table = fast_lab()](const cv::Vec3b& c) {
                   const Eigen::Vector3f lab = table(c[0], c[1], c[2]);
                   return cv::Vec3f(lab[0], lab[1], lab[2]);
                 });
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
