#include "perception/segmentation/morphology.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "perception/segmentation/classification.hpp"
#include "tests/perception/segmentation/class_pictures.hpp"

namespace ballservo {
namespace {

/// The same by OpenCV, class by class, on pictures of class numbers.
cv::Mat reference_open(const cv::Mat& numbers, int classes) {
  cv::Mat opened = cv::Mat::zeros(numbers.size(), CV_8UC1), mask;
  for (int k = 1; k <= classes; ++k) {
    cv::erode(numbers == k, mask, cv::Mat());
    cv::dilate(mask, mask, cv::Mat());
    opened.setTo(k, mask);
  }
  return opened;
}

cv::Mat reference_close(const cv::Mat& opened, int classes) {
  cv::Mat closed = opened.clone(), mask;
  for (int k = 1; k <= classes; ++k) {
    cv::dilate(opened == k, mask, cv::Mat(), cv::Point(-1, -1), 2);
    cv::erode(mask, mask, cv::Mat(), cv::Point(-1, -1), 2);
    closed.setTo(k, mask & (closed == 0));
  }
  return closed;
}

TEST(Morphology, IsOpenCVsOnRandomPictures) {
  auto engine = random_stream(6, "morphology_test");
  ClassMorphology fastest, portable(Instructions::portable);
  ClassPictures opened, closed;
  for (const int width : {1, 2, 3, 5, 62, 63, 64, 65, 66, 67, 100, 128, 129, 130, 192, 200}) {
    for (const int height : {1, 2, 3, 4, 7, 50}) {
      for (const int classes : {1, 2, 5}) {
        for (const double noise : {0.0, 0.03, 0.3}) {
          const cv::Mat numbers = test::random_classes({width, height}, classes, noise, engine);
          const cv::Mat expected = reference_open(numbers, classes);
          for (ClassMorphology* const morphology : {&fastest, &portable}) {
            morphology->open(test::to_bits(numbers, classes), opened);
            morphology->close(opened, closed);
            ASSERT_TRUE(test::ends_are_clear(opened) && test::ends_are_clear(closed));
            ASSERT_EQ(cv::norm(class_numbers(opened, numbers.size()), expected), 0) << width << "x" << height;
            ASSERT_EQ(cv::norm(class_numbers(closed, numbers.size()), reference_close(expected, classes)), 0)
                << width << "x" << height;
          }
        }
      }
    }
  }
}

TEST(Morphology, OpeningDropsSpecksAndClosingFillsPinholes) {
  cv::Mat numbers = cv::Mat::zeros(60, 80, CV_8UC1);
  cv::rectangle(numbers, {20, 20}, {50, 45}, 1, cv::FILLED);
  numbers.at<std::uint8_t>(5, 5) = 1;    // a speck
  numbers.at<std::uint8_t>(30, 30) = 0;  // pinholes
  numbers.at<std::uint8_t>(35, 40) = 2;
  ClassMorphology morphology;
  ClassPictures opened, closed;
  morphology.open(test::to_bits(numbers, 2), opened);
  EXPECT_FALSE(opened[0].at(5, 5));
  EXPECT_FALSE(opened[1].at(40, 35));
  morphology.close(opened, closed);
  EXPECT_TRUE(closed[0].at(30, 30));
  EXPECT_EQ(cv::countNonZero(class_numbers(closed, numbers.size()) == 1), 31 * 26);
}

TEST(Morphology, KeepsABallAtThePicturesBorder) {
  cv::Mat numbers = cv::Mat::zeros(40, 40, CV_8UC1);
  cv::rectangle(numbers, {0, 10}, {8, 25}, 1, cv::FILLED);
  ClassMorphology morphology;
  ClassPictures opened, closed;
  morphology.open(test::to_bits(numbers, 1), opened);
  morphology.close(opened, closed);
  EXPECT_EQ(cv::norm(class_numbers(closed, numbers.size()), numbers), 0);
}

}  // namespace
}  // namespace ballservo
