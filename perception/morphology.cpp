#include "perception/morphology.hpp"

#include <array>
#include <opencv2/imgproc.hpp>

namespace ballservo {
namespace {

// The bounding box of each class, so that each is filtered only where it occurs.
std::array<cv::Rect, 256> class_boxes(const cv::Mat& classes) {
  std::array<int, 256> left, right, top, bottom;
  left.fill(classes.cols);
  right.fill(-1);
  top.fill(classes.rows);
  bottom.fill(-1);
  for (int v = 0; v < classes.rows; ++v) {
    const std::uint8_t* row = classes.ptr<std::uint8_t>(v);
    for (int u = 0; u < classes.cols; ++u) {
      const std::uint8_t k = row[u];
      if (k == 0) continue;
      left[k] = std::min(left[k], u);
      right[k] = std::max(right[k], u);
      top[k] = std::min(top[k], v);
      bottom[k] = v;
    }
  }
  std::array<cv::Rect, 256> boxes;
  for (std::size_t k = 1; k < boxes.size(); ++k) {
    if (right[k] >= 0) boxes[k] = cv::Rect(left[k], top[k], right[k] - left[k] + 1, bottom[k] - top[k] + 1);
  }
  return boxes;
}

cv::Rect grown(const cv::Rect& box, int margin, const cv::Size& picture) {
  return cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
         cv::Rect({0, 0}, picture);
}

}  // namespace

void ClassMorphology::open(const cv::Mat& classes, cv::Mat& opened, int class_count) {
  opened.create(classes.size(), CV_8UC1);
  opened.setTo(0);
  const auto boxes = class_boxes(classes);
  // The element of OpenCV's default, a 3x3 square; outside the picture counts as inside for erosion and
  // outside for dilation, so that a ball cut by the border is not eaten from there.
  for (int k = 1; k <= class_count; ++k) {
    if (boxes[static_cast<std::size_t>(k)].empty()) continue;
    const cv::Rect box = grown(boxes[static_cast<std::size_t>(k)], 2, classes.size());
    cv::compare(classes(box), k, mask_, cv::CMP_EQ);
    cv::erode(mask_, result_, cv::Mat());
    cv::dilate(result_, mask_, cv::Mat());
    opened(box).setTo(k, mask_);
  }
}

void ClassMorphology::close(const cv::Mat& opened, cv::Mat& closed, int class_count) {
  opened.copyTo(closed);
  const auto boxes = class_boxes(opened);
  for (int k = 1; k <= class_count; ++k) {
    if (boxes[static_cast<std::size_t>(k)].empty()) continue;
    const cv::Rect box = grown(boxes[static_cast<std::size_t>(k)], 4, opened.size());
    cv::compare(opened(box), k, mask_, cv::CMP_EQ);
    cv::dilate(mask_, result_, cv::Mat(), cv::Point(-1, -1), 2);
    cv::erode(result_, mask_, cv::Mat(), cv::Point(-1, -1), 2);
    cv::compare(closed(box), 0, result_, cv::CMP_EQ);
    cv::bitwise_and(mask_, result_, mask_);
    closed(box).setTo(k, mask_);
  }
}

}  // namespace ballservo
