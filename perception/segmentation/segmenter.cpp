#include "perception/segmentation/segmenter.hpp"

#include <utility>

namespace ballservo {
namespace {

constexpr int worth_sharing_px = 100000;  // below, threads cost more to wake than they save

}  // namespace

Segmenter::Segmenter(std::shared_ptr<const ColorTable> colors, int threads)
    : colors_(std::move(colors)), threads_(threads) {}

const SegmentedWindow& Segmenter::segment(const cv::Mat& bgr, const cv::Rect& window) {
  segmented_.window = window;
  classify(bgr(window), colors_, segmented_.classified, ClassificationKernel::fastest,
           window.area() >= worth_sharing_px ? threads_ : 1);
  morphology_.open(segmented_.classified, segmented_.opened);
  morphology_.close(segmented_.opened, segmented_.closed);
  return segmented_;
}

}  // namespace ballservo
