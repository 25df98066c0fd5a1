#include "perception/segmentation/regions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <set>

#include "perception/segmentation/classification.hpp"
#include "tests/perception/segmentation/class_pictures.hpp"

namespace ballservo {
namespace {

cv::Mat blank() { return cv::Mat::zeros(60, 80, CV_8UC1); }

/// A picture's regions and what was asked of them.
struct Segmented {
  Segmented(const cv::Mat& numbers, int classes, int max_runs = 1 << 16) : map(max_runs) {
    map.update(test::to_bits(numbers, classes), numbers.size());
  }
  std::vector<BoundaryPixel> boundary(int region) const {
    std::vector<BoundaryPixel> pixels;
    map.boundary(region, pixels);
    return pixels;
  }
  /// The first region of that class that has not been absorbed.
  int region_of(ClassIndex color_class) const {
    for (std::size_t i = 0; i < map.regions().size(); ++i) {
      if (map.regions()[i].color_class == color_class && map.regions()[i].absorbed_by < 0)
        return static_cast<int>(i);
    }
    return -1;
  }
  RegionMap map;
};

/// The same by flooding, pixel by pixel: labels in raster order of the regions' first pixels.
cv::Mat1i flooded(const cv::Mat& numbers) {
  cv::Mat1i labels(numbers.size(), -1);
  int count = 0;
  for (int v = 0; v < numbers.rows; ++v) {
    for (int u = 0; u < numbers.cols; ++u) {
      if (labels(v, u) >= 0) continue;
      const std::uint8_t color_class = numbers.at<std::uint8_t>(v, u);
      std::vector<cv::Point> left{{u, v}};
      labels(v, u) = count;
      while (!left.empty()) {
        const cv::Point at = left.back();
        left.pop_back();
        for (int i = 0; i < 9; ++i) {
          const cv::Point step(i % 3 - 1, i / 3 - 1), next = at + step;
          if (color_class == no_class && step.x != 0 && step.y != 0) continue;
          if (!cv::Rect({0, 0}, numbers.size()).contains(next) || labels(next) >= 0) continue;
          if (numbers.at<std::uint8_t>(next) != color_class) continue;
          labels(next) = count;
          left.push_back(next);
        }
      }
      ++count;
    }
  }
  return labels;
}

const std::array<cv::Point, 4> steps{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

void expect_equal(const std::vector<BoundaryPixel>& found, const cv::Mat1i& labels, int region) {
  std::size_t next = 0;
  for (int v = 1; v + 1 < labels.rows; ++v) {
    for (int u = 1; u + 1 < labels.cols; ++u) {
      if (labels(v, u) != region) continue;
      const bool is_boundary = std::any_of(steps.begin(), steps.end(), [&](const cv::Point& step) {
        return labels(cv::Point(u, v) + step) != region;
      });
      if (!is_boundary) continue;
      ASSERT_LT(next, found.size());
      const BoundaryPixel& pixel = found[next++];
      ASSERT_EQ(cv::Point(pixel.u_px, pixel.v_px), cv::Point(u, v));
    }
  }
  ASSERT_EQ(next, found.size());
}

// Class, pixels, box, border, neighbours, absorption, what that does to the class pictures, and outlines.
TEST(Regions, AreThoseOfFlooding) {
  auto engine = random_stream(7, "regions_test");
  for (int trial = 0; trial < 300; ++trial) {
    const int classes = 1 + trial % 3;
    const cv::Size size(1 + static_cast<int>(uniform_index(engine, 150)),
                        1 + static_cast<int>(uniform_index(engine, 40)));
    const cv::Mat numbers = test::random_classes(size, classes, trial % 2 ? 0.02 : 0.2, engine);
    const Segmented segmented(numbers, classes);
    cv::Mat1i labels = flooded(numbers);
    double last = 0;
    cv::minMaxLoc(labels, nullptr, &last);
    const std::vector<Region>& regions = segmented.map.regions();
    ASSERT_EQ(regions.size(), static_cast<std::size_t>(last) + 1);

    std::vector<std::set<int>> neighbors(regions.size());
    std::vector<int> pixels(regions.size(), 0);
    std::vector<cv::Rect> boxes(regions.size());
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        const int label = labels(v, u);
        ASSERT_EQ(regions[static_cast<std::size_t>(label)].color_class, numbers.at<std::uint8_t>(v, u));
        ++pixels[static_cast<std::size_t>(label)];
        boxes[static_cast<std::size_t>(label)] |= cv::Rect(u, v, 1, 1);
        for (const cv::Point& step : steps) {
          const cv::Point next = cv::Point(u, v) + step;
          if (cv::Rect({0, 0}, size).contains(next) && labels(next) != label)
            neighbors[static_cast<std::size_t>(label)].insert(labels(next));
        }
      }
    }
    for (std::size_t i = 0; i < regions.size(); ++i) {
      ASSERT_EQ(regions[i].only_neighbor, neighbors[i].empty()       ? Region::no_neighbor
                                          : neighbors[i].size() == 1 ? *neighbors[i].begin()
                                                                     : Region::several);
      const cv::Rect& box = boxes[i];
      ASSERT_EQ(regions[i].box, box);
      ASSERT_EQ(regions[i].touches_border,
                box.x == 0 || box.y == 0 || box.br().x == size.width || box.br().y == size.height);
      int with_absorbed = pixels[i];
      for (std::size_t k = 0; k < regions.size(); ++k) {
        if (regions[k].absorbed_by == static_cast<int>(i)) with_absorbed += pixels[k];
      }
      ASSERT_EQ(regions[i].pixels, with_absorbed);
      if (regions[i].absorbed_by >= 0) {
        ASSERT_EQ(neighbors[i], std::set<int>{regions[i].absorbed_by});
      }
    }
    cv::Mat1i whole = labels.clone();
    for (std::size_t i = 0; i < regions.size(); ++i) {
      if (regions[i].absorbed_by >= 0) whole.setTo(regions[i].absorbed_by, labels == static_cast<int>(i));
    }
    for (std::size_t i = 0; i < regions.size(); ++i) {
      const ClassIndex color_class = regions[i].color_class;
      if (color_class == no_class || regions[i].absorbed_by >= 0) continue;
      expect_equal(segmented.boundary(static_cast<int>(i)), whole, static_cast<int>(i));
      for (int v = 0; v < size.height; ++v) {
        for (int u = 0; u < size.width; ++u) {
          if (whole(v, u) == static_cast<int>(i)) {
            ASSERT_TRUE(segmented.map.classes()[color_class - 1u].at(u, v));
          }
        }
      }
    }
  }
}

TEST(Regions, AbsorbAHighlightButNotABallInFrontOfALargerOne) {
  cv::Mat numbers = blank();
  cv::circle(numbers, {40, 30}, 22, 1, cv::FILLED);
  cv::circle(numbers, {34, 24}, 3, 0, cv::FILLED);  // a highlight without colour
  cv::circle(numbers, {46, 36}, 8, 2, cv::FILLED);  // a ball of another class
  const Segmented segmented(numbers, 2);
  EXPECT_TRUE(segmented.map.classes()[0].at(34, 24));
  EXPECT_FALSE(segmented.map.classes()[0].at(46, 36));
  EXPECT_GE(segmented.region_of(2), 0);
  const int ball = segmented.region_of(1);
  for (const BoundaryPixel& pixel : segmented.boundary(ball))
    EXPECT_GT(cv::norm(cv::Point(pixel.u_px, pixel.v_px) - cv::Point(34, 24)), 5);
}

TEST(Regions, OfOtherClassesAreNeighboursToo) {
  cv::Mat numbers = blank();
  cv::rectangle(numbers, {10, 10}, {30, 30}, 1, cv::FILLED);
  cv::rectangle(numbers, {31, 10}, {50, 30}, 2, cv::FILLED);
  const Segmented segmented(numbers, 2);
  const auto& regions = segmented.map.regions();
  EXPECT_EQ(regions[static_cast<std::size_t>(segmented.region_of(1))].only_neighbor, Region::several);
}

TEST(Regions, BoundaryIsTheRimWithoutHolesAndWithoutThePicturesBorder) {
  cv::Mat numbers = blank();
  cv::rectangle(numbers, {0, 10}, {20, 29}, 1, cv::FILLED);
  numbers.at<std::uint8_t>(20, 10) = 0;
  const Segmented segmented(numbers, 1);
  const auto boundary = segmented.boundary(segmented.region_of(1));
  EXPECT_EQ(boundary.size(), 20u + 20u + 18u);  // top and bottom without the column at the border, right side
  for (const BoundaryPixel& pixel : boundary) EXPECT_GT(pixel.u_px, 0);
}

TEST(Regions, NormalsPointAwayFromTheMiddleOfThePixelsAround) {
  auto engine = random_stream(8, "regions_test");
  for (int trial = 0; trial < 40; ++trial) {
    const cv::Size size(1 + static_cast<int>(uniform_index(engine, 140)),
                        1 + static_cast<int>(uniform_index(engine, 12)));
    const cv::Mat numbers = test::random_classes(size, 1, 0.2, engine);
    const ClassPictures pictures = test::to_bits(numbers, 1);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u) {
        cv::Point2f sum(0, 0);
        for (int i = 0; i < 49; ++i) {
          const cv::Point step(i % 7 - 3, i / 7 - 3);
          const cv::Point at(std::clamp(u + step.x, 0, size.width - 1),
                             std::clamp(v + step.y, 0, size.height - 1));
          if (numbers.at<std::uint8_t>(at) == 1) sum -= cv::Point2f(step);
        }
        const double length = std::max(1e-9, cv::norm(sum));
        const Eigen::Vector2f normal = outward_normal(pictures[0], {u, v, {}});
        ASSERT_NEAR(normal.x(), sum.x / length, 1e-5);
        ASSERT_NEAR(normal.y(), sum.y / length, 1e-5);
      }
    }
  }
}

TEST(Regions, CopeWithEmptyFullAndTinyPictures) {
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(2, 1), cv::Size(1, 5), cv::Size(64, 48)}) {
    for (const int value : {0, 1}) {
      for (const int classes : {value, 2}) {
        const Segmented segmented(cv::Mat(size, CV_8UC1, cv::Scalar(value)), classes);
        ASSERT_EQ(segmented.map.regions().size(), 1u);
        EXPECT_EQ(segmented.map.regions()[0].pixels, size.area());
        EXPECT_TRUE(segmented.boundary(0).empty());
      }
    }
  }
}

cv::Mat checkerboard() {
  cv::Mat numbers = blank();
  for (int v = 0; v < numbers.rows; ++v) {
    for (int u = 0; u < numbers.cols; ++u) numbers.at<std::uint8_t>(v, u) = (u + v) % 2;
  }
  return numbers;
}

TEST(Regions, CopeWithACheckerboard) {
  const Segmented segmented(checkerboard(), 1);
  int pixels = 0;
  for (const Region& region : segmented.map.regions()) pixels += region.absorbed_by < 0 ? region.pixels : 0;
  EXPECT_EQ(pixels, 60 * 80);
  EXPECT_EQ(segmented.map.shortest_run_px(), 1);
}

TEST(Regions, KeepTheLargestOfTooManyAndSaySo) {
  cv::Mat numbers = checkerboard();
  cv::circle(numbers, {40, 30}, 12, 0, cv::FILLED);
  cv::circle(numbers, {40, 30}, 10, 1, cv::FILLED);
  const Segmented segmented(numbers, 1, 200);
  EXPECT_GT(segmented.map.shortest_run_px(), 1);
  int of_class = 0;
  for (const Region& region : segmented.map.regions()) of_class += region.color_class == 1;
  EXPECT_EQ(of_class, 1);
  EXPECT_GT(segmented.map.regions()[static_cast<std::size_t>(segmented.region_of(1))].pixels, 250);
  EXPECT_EQ(cv::countNonZero(class_numbers(segmented.map.classes(), numbers.size())),
            segmented.map.regions()[static_cast<std::size_t>(segmented.region_of(1))].pixels);
  // Too few for a picture at all: what is left is background.
  EXPECT_EQ(Segmented(numbers, 1, 1).map.regions().size(), 1u);
}

}  // namespace
}  // namespace ballservo
