#include "app/report/picture.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace ballservo {
namespace {

TEST(PictureBytes, AreAFileOfThatFormat) {
  const cv::Mat picture(5, 7, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(picture_bytes(picture, PictureFormat::png).rfind("\x89PNG", 0), 0u);
  EXPECT_EQ(picture_bytes(picture, PictureFormat::jpeg).rfind("\xff\xd8\xff", 0), 0u);
  EXPECT_THROW(picture_bytes({}, PictureFormat::png), std::invalid_argument);
}

TEST(Viewable, TakesAnyDepthAndChannels) {
  for (const int depth : {CV_8U, CV_16U, CV_32S, CV_32F, CV_64F}) {
    for (const int channels : {1, 3, 4}) {
      const cv::Mat shown = viewable(cv::Mat(3, 4, CV_MAKETYPE(depth, channels), cv::Scalar::all(7)));
      EXPECT_EQ(shown.type(), CV_8UC3);
      EXPECT_EQ(shown.size(), cv::Size(4, 3));
    }
  }
  EXPECT_TRUE(viewable({}).empty());
}

TEST(Viewable, SpreadsTheFiniteRange) {
  cv::Mat numbers = (cv::Mat_<float>(1, 4) << -2, 0, 2, std::numeric_limits<float>::quiet_NaN());
  const cv::Mat shown = viewable(numbers);
  EXPECT_EQ(shown.at<cv::Vec3b>(0, 0)[0], 0);
  EXPECT_EQ(shown.at<cv::Vec3b>(0, 1)[0], 128);
  EXPECT_EQ(shown.at<cv::Vec3b>(0, 2)[0], 255);
  EXPECT_EQ(shown.at<cv::Vec3b>(0, 3)[0], 0);
}

TEST(LabelledGrid, HoldsEveryPictureUnscaledWhereAllAreAlike) {
  std::vector<std::pair<std::string, cv::Mat>> pictures;
  const std::vector<cv::Scalar> colors{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  for (const cv::Scalar& color : colors) pictures.emplace_back("one", cv::Mat(80, 150, CV_8UC3, color));
  for (const int columns : {-1, 1, 2, 3, 50}) {
    const cv::Mat grid = labelled_grid(pictures, columns);
    for (const cv::Scalar& color : colors) {
      cv::Mat mask;
      cv::inRange(grid, color, color, mask);
      EXPECT_EQ(cv::countNonZero(mask), 80 * 150);
    }
  }
}

TEST(LabelledGrid, StandsOddInput) {
  EXPECT_TRUE(labelled_grid({}, 3).empty());
  const cv::Mat grid =
      labelled_grid({{"empty", {}},
                     {std::string(500, 'x') + "\xc3\xa4\n", cv::Mat(1, 900, CV_32F, cv::Scalar(1))},
                     {"mask", cv::Mat(300, 2, CV_8U, cv::Scalar(255))}},
                    2);
  EXPECT_EQ(grid.type(), CV_8UC3);
}

}  // namespace
}  // namespace ballservo
