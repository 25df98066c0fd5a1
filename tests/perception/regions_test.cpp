#include "perception/regions.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "calibration/files/random.hpp"

namespace ballservo {
namespace {

cv::Mat blank() { return cv::Mat::zeros(60, 80, CV_8UC1); }

TEST(Regions, AgreeWithOpenCVsComponents) {
  auto engine = random_stream(4, "regions_test");
  for (int trial = 0; trial < 20; ++trial) {
    cv::Mat classes = blank();
    for (int i = 0; i < 40; ++i) {
      const cv::Point p(static_cast<int>(uniform_index(engine, 80)),
                        static_cast<int>(uniform_index(engine, 60)));
      cv::circle(classes, p, static_cast<int>(uniform_index(engine, 6)), 1, cv::FILLED);
    }
    RegionMap map;
    map.update(classes);
    cv::Mat labels;
    const int expected = cv::connectedComponents(classes, labels, 8) - 1;
    int found = 0, pixels = 0;
    for (const Region& region : map.regions()) {
      if (region.color_class == 1) ++found;
      if (region.absorbed_by < 0 && region.color_class == 1) pixels += region.pixels;
    }
    EXPECT_EQ(found, expected);
    EXPECT_GE(pixels, cv::countNonZero(classes));  // absorbed holes count too
  }
}

TEST(Regions, AbsorbAHighlightButNotABallInFrontOfALargerOne) {
  cv::Mat classes = blank();
  cv::circle(classes, {40, 30}, 22, 1, cv::FILLED);
  cv::circle(classes, {34, 24}, 3, 0, cv::FILLED);  // a highlight without colour
  cv::circle(classes, {46, 36}, 8, 2, cv::FILLED);  // a ball of another class
  RegionMap map;
  map.update(classes);
  const int ball = map.region_at(40, 12);
  EXPECT_EQ(map.region_at(34, 24), ball);
  EXPECT_NE(map.region_at(46, 36), ball);
}

TEST(Regions, KnowTheirNeighbours) {
  cv::Mat classes = blank();
  cv::rectangle(classes, {10, 10}, {30, 30}, 1, cv::FILLED);
  cv::rectangle(classes, {31, 10}, {50, 30}, 2, cv::FILLED);
  RegionMap map;
  map.update(classes);
  const int left = map.region_at(20, 20), right = map.region_at(40, 20);
  const auto& neighbors = map.regions()[static_cast<std::size_t>(left)].neighbors;
  EXPECT_NE(std::find(neighbors.begin(), neighbors.end(), right), neighbors.end());
}

TEST(Regions, BoundaryIsTheRimWithoutHolesAndWithoutThePicturesBorder) {
  cv::Mat classes = blank();
  cv::rectangle(classes, {0, 10}, {20, 29}, 1, cv::FILLED);
  classes.at<std::uint8_t>(20, 10) = 0;
  RegionMap map;
  map.update(classes);
  std::vector<BoundaryPixel> boundary;
  map.boundary(map.region_at(5, 15), boundary);
  EXPECT_EQ(boundary.size(), 20u + 20u + 18u);  // top and bottom without the column at the border, right side
  for (const BoundaryPixel& pixel : boundary) {
    EXPECT_GT(pixel.u_px, 0);
    EXPECT_NEAR(pixel.outward.norm(), 1, 1e-5);
  }
}

TEST(Regions, CopeWithEmptyFullAndTinyPictures) {
  RegionMap map;
  std::vector<BoundaryPixel> boundary;
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 5), cv::Size(64, 48)}) {
    for (const int value : {0, 1}) {
      map.update(cv::Mat(size, CV_8UC1, cv::Scalar(value)));
      ASSERT_EQ(map.regions().size(), 1u);
      EXPECT_EQ(map.regions()[0].pixels, size.area());
      map.boundary(0, boundary);
      EXPECT_TRUE(boundary.empty());
    }
  }
}

TEST(Regions, CopeWithACheckerboard) {
  cv::Mat classes = blank();
  for (int v = 0; v < classes.rows; ++v) {
    for (int u = 0; u < classes.cols; ++u) classes.at<std::uint8_t>(v, u) = (u + v) % 2;
  }
  RegionMap map;
  map.update(classes);
  int pixels = 0;
  for (const Region& region : map.regions()) pixels += region.absorbed_by < 0 ? region.pixels : 0;
  EXPECT_EQ(pixels, classes.rows * classes.cols);
}

}  // namespace
}  // namespace ballservo
