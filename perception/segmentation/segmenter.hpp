// Stages 1 and 2: each class's pixels in a picture.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "perception/segmentation/classification.hpp"
#include "perception/segmentation/morphology.hpp"

namespace ballservo {

/// A window of a picture by class, as classified, without specks (opened), and without holes (closed).
struct SegmentedWindow {
  cv::Rect window;
  ClassPictures classified, opened, closed;
};

class Segmenter {
 public:
  /// `threads` share the rows of large windows.
  Segmenter(std::shared_ptr<const ColorTable> colors, int threads);

  const ColorTable& colors() const { return colors_.colors(); }
  /// Looks colours up for another light than the taught one.
  void set_light(const LightCells& light) { colors_.set_light(light); }

  /// `window` lies in the picture (8-bit BGR). Valid until the next call.
  const SegmentedWindow& segment(const cv::Mat& bgr, const cv::Rect& window);

 private:
  ColorLookup colors_;
  int threads_;
  ClassMorphology morphology_;
  SegmentedWindow segmented_;
};

}  // namespace ballservo
