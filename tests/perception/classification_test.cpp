#include "perception/classification.hpp"

#include <gtest/gtest.h>

#include "calibration/files/random.hpp"
#include "perception/morphology.hpp"
#include "tests/perception/painted_ball.hpp"

namespace ballservo {
namespace {

TEST(Classification, IsTheTablesAnswerForEveryPixel) {
  const auto colors = test::red_and_green();
  auto engine = random_stream(1, "classification_test");
  cv::Mat big(37, 53, CV_8UC3);
  for (int v = 0; v < big.rows; ++v) {
    for (int u = 0; u < big.cols; ++u) {
      for (int c = 0; c < 3; ++c)
        big.at<cv::Vec3b>(v, u)[c] = static_cast<std::uint8_t>(uniform_index(engine, 256));
    }
  }
  // A view whose rows do not follow each other in memory, of odd width.
  const cv::Mat view = big(cv::Rect(3, 5, 41, 29));
  cv::Mat classes;
  classify(view, *colors, classes);
  for (int v = 0; v < view.rows; ++v) {
    for (int u = 0; u < view.cols; ++u) {
      const cv::Vec3b& p = view.at<cv::Vec3b>(v, u);
      ASSERT_EQ(classes.at<ClassIndex>(v, u), colors->classify(p[0], p[1], p[2]));
    }
  }
}

TEST(Morphology, OpeningDropsSpecksAndClosingFillsPinholes) {
  cv::Mat classes = cv::Mat::zeros(60, 80, CV_8UC1), opened, closed;
  cv::rectangle(classes, {20, 20}, {50, 45}, 1, cv::FILLED);
  classes.at<std::uint8_t>(5, 5) = 1;    // a speck
  classes.at<std::uint8_t>(30, 30) = 0;  // pinholes
  classes.at<std::uint8_t>(35, 40) = 2;
  ClassMorphology morphology;
  morphology.open(classes, opened, 2);
  EXPECT_EQ(opened.at<std::uint8_t>(5, 5), 0);
  EXPECT_EQ(opened.at<std::uint8_t>(35, 40), 0);
  morphology.close(opened, closed, 2);
  EXPECT_EQ(closed.at<std::uint8_t>(30, 30), 1);
  EXPECT_EQ(cv::countNonZero(closed == 1), 31 * 26);
}

TEST(Morphology, KeepsABallAtThePicturesBorder) {
  cv::Mat classes = cv::Mat::zeros(40, 40, CV_8UC1), opened, closed;
  cv::rectangle(classes, {0, 10}, {8, 25}, 1, cv::FILLED);
  ClassMorphology morphology;
  morphology.open(classes, opened, 1);
  morphology.close(opened, closed, 1);
  EXPECT_EQ(cv::countNonZero(closed), cv::countNonZero(classes));
}

}  // namespace
}  // namespace ballservo
