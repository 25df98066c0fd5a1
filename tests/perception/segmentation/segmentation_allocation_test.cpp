// After its first picture, the segmentation takes no memory, whatever the next ones show.
#include <gtest/gtest.h>

#include "perception/segmentation/classification.hpp"
#include "perception/segmentation/morphology.hpp"
#include "perception/segmentation/regions.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/support/allocation_counter.hpp"

namespace ballservo {
namespace {

/// Blots of both classes and of none, of any size down to a pixel.
cv::Mat blots(int largest_px) {
  cv::Mat bgr = test::grey_picture();
  auto engine = random_stream(1, "segmentation_allocation_test", static_cast<std::uint64_t>(largest_px));
  const auto any = [&](int count) {
    return static_cast<int>(uniform_index(engine, static_cast<std::uint32_t>(count)));
  };
  for (int i = 0; i < 200000 / (largest_px * largest_px); ++i) {
    const cv::Rect blot(any(bgr.cols), any(bgr.rows), 1 + any(largest_px), 1 + any(largest_px));
    const std::array<cv::Vec3b, 3> colors{test::red, test::green, test::grey};
    bgr(blot & cv::Rect({0, 0}, bgr.size())).setTo(colors[static_cast<std::size_t>(any(3))]);
  }
  return bgr;
}

TEST(SegmentationAllocation, NoPictureTakesMemoryAfterTheFirst) {
  ColorLookup colors(test::red_and_green());
  ClassPictures classes, opened, closed;
  ClassMorphology morphology;
  RegionMap regions;
  const auto segment = [&](const cv::Mat& bgr) {
    colors.set_light(LightCells::as_taught());
    classify(bgr, colors, classes);
    morphology.open(classes, opened);
    morphology.close(opened, closed);
    regions.update(closed, bgr.size());
    regions.update(classes, bgr.size());  // with all its noise
  };
  segment(test::grey_picture());
  const std::vector<cv::Mat> pictures{blots(1), blots(3), blots(9), blots(60)};
  const long before = test::allocations();
  for (const cv::Mat& bgr : pictures) {
    segment(bgr);
    segment(bgr(cv::Rect(20, 30, 101, 63)));
  }
  EXPECT_EQ(test::allocations() - before, 0);
}

}  // namespace
}  // namespace ballservo
