// What the search for balls looks at: exposure and noise.
#include <gtest/gtest.h>

#include "calibration/teaching/clear_picture.hpp"
#include "tests/calibration/color_pictures.hpp"

namespace ballservo {
namespace {

using namespace test;

TEST(ClearPicture, AGoodPictureStaysAsItIs) {
  cv::Mat picture = grey_picture();
  picture.rowRange(0, 10).setTo(cv::Scalar(200, 210, 220));
  add_noise(picture, 1.5, 1);
  EXPECT_EQ(clear_picture(picture).data, picture.data);
}

TEST(ClearPicture, TellsTheNoise) {
  for (const double sigma : {3.0, 6.0, 12.0}) {
    cv::Mat picture = grey_picture();
    add_noise(picture, sigma, 2);
    EXPECT_NEAR(picture_noise(picture), sigma, 0.1 * sigma + 0.5);
  }
  EXPECT_EQ(picture_noise(grey_picture()), 0.5);
}

TEST(ClearPicture, SmoothsNoise) {
  cv::Mat picture = grey_picture();
  picture.rowRange(0, 10).setTo(cv::Scalar::all(200));
  add_noise(picture, 8, 3);
  cv::Scalar mean, deviation;
  cv::meanStdDev(clear_picture(picture).rowRange(40, 200), mean, deviation);
  EXPECT_NEAR(mean[1], 140, 0.5);
  EXPECT_LT(deviation[1], 2);
}

TEST(ClearPicture, RaisesWhatIsDarkUpToALimitAndLeavesTheOriginal) {
  cv::Mat picture(240, 320, CV_8UC3, cv::Scalar(30, 60, 40));
  EXPECT_EQ(clear_picture(picture).at<cv::Vec3b>(100, 100), cv::Vec3b(76, 153, 102));
  EXPECT_EQ(picture.at<cv::Vec3b>(100, 100), cv::Vec3b(30, 60, 40));
  const cv::Mat night(240, 320, CV_8UC3, cv::Scalar(5, 10, 5));
  EXPECT_EQ(clear_picture(night).at<cv::Vec3b>(100, 100), cv::Vec3b(20, 40, 20));
  // A lamp in a corner does not make a dark room bright; a hundredth of the picture does.
  picture(cv::Rect(0, 0, 20, 20)).setTo(cv::Scalar::all(250));
  EXPECT_EQ(clear_picture(picture).at<cv::Vec3b>(100, 100)[1], 153);
  picture(cv::Rect(0, 0, 40, 40)).setTo(cv::Scalar::all(250));
  EXPECT_EQ(clear_picture(picture).at<cv::Vec3b>(100, 100)[1], 60);
}

TEST(ClearPicture, TinyPictures) {
  EXPECT_EQ(clear_picture(cv::Mat(1, 1, CV_8UC3, cv::Scalar::all(200))).at<cv::Vec3b>(0, 0)[0], 200);
  EXPECT_EQ(clear_picture(cv::Mat(2, 1, CV_8UC3, cv::Scalar::all(0))).at<cv::Vec3b>(1, 0)[0], 0);
}

}  // namespace
}  // namespace ballservo
