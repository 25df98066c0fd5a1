#include "app/report/picture.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace ballservo {
namespace {

TEST(PictureBytes, AreAFileOfThatFormat) {
  const cv::Mat picture(5, 7, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(picture_bytes(picture, ".png").rfind("\x89PNG", 0), 0u);
  EXPECT_EQ(picture_bytes(picture, ".jpg").rfind("\xff\xd8\xff", 0), 0u);
  EXPECT_THROW(picture_bytes({}, ".png"), std::invalid_argument);
}

TEST(LabelledGrid, HoldsEveryPictureUnscaledWhereAllAreAlike) {
  std::vector<std::pair<std::string, cv::Mat>> pictures;
  const std::vector<cv::Scalar> colors{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}};
  for (int rows = 1; rows <= 3; ++rows) {
    for (const cv::Scalar& color : colors) pictures.emplace_back("one", cv::Mat(80, 150, CV_8UC3, color));
    const cv::Mat grid = labelled_grid(pictures);
    for (const cv::Scalar& color : colors) {
      cv::Mat mask;
      cv::inRange(grid, color, color, mask);
      EXPECT_EQ(cv::countNonZero(mask), rows * 80 * 150);
    }
  }
}

TEST(LabelledGrid, StandsOddInput) {
  EXPECT_TRUE(labelled_grid({}).empty());
  const cv::Mat grid = labelled_grid({{"empty", {}},
                                      {std::string(500, 'x') + "\xc3\xa4\n", cv::Mat(1, 900, CV_8UC3)},
                                      {"narrow", cv::Mat(300, 2, CV_8UC3)},
                                      {"below", cv::Mat(2, 2, CV_8UC3)}});
  EXPECT_EQ(grid.type(), CV_8UC3);
}

}  // namespace
}  // namespace ballservo
