#include "app/report/stage_pictures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "app/report/overlay.hpp"
#include "calibration/color/color_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

TEST(StagePictures, SayWhyACircleIsNoBall) {
  cv::Mat bgr(240, 320, CV_8UC3, cv::Scalar(90, 90, 90));
  DetectionStages stages;
  stages.classified = stages.opened = stages.closed = cv::Mat::zeros(bgr.size(), CV_8UC1);
  DetectionStages::Candidate& rejected = stages.candidates.emplace_back();
  rejected.color_class = 1;
  rejected.estimate.radius_px = 40;
  rejected.votes.rows = rejected.votes.columns = 1;
  rejected.votes.counts = {1};
  CameraParameters lens;
  lens.size = {bgr.cols, bgr.rows};
  lens.fx_px = lens.fy_px = 300;
  lens.cx_px = 160;
  lens.cy_px = 120;
  const Detector detector(
      std::make_shared<RayTable>(Camera(lens)),
      std::make_shared<ColorTable>(read_color_file(test::project_data_dir() / "colors/red.colors")), {});
  const auto marked = [&] {
    const auto pictures = stage_pictures(bgr, stages, detector);
    const auto estimate = std::find_if(pictures.begin(), pictures.end(), [](const auto& each) {
      return each.first.rfind("estimate by votes", 0) == 0;
    });
    return estimate == pictures.end() ? -1.0 : cv::norm(estimate->second, bgr, cv::NORM_L1);
  };
  EXPECT_EQ(marked(), 0);
  rejected.reason = "too small";
  EXPECT_GT(marked(), 0);
  rejected.accepted = true;
  EXPECT_EQ(marked(), 0);
}

TEST(StagePictures, NoTextCoversAnother) {
  const cv::Mat blank(240, 320, CV_8UC3, cv::Scalar(90, 90, 90));
  const auto marked = [&](const cv::Mat& picture) { return cv::norm(picture, blank, cv::NORM_L1); };
  for (const cv::Point at : {cv::Point(160, 120), cv::Point(-900, 900), cv::Point(320, 0)}) {
    std::vector<cv::Rect> texts;
    cv::Mat all = blank.clone();
    double each_alone = 0;
    for (int k = 0; k < 9; ++k) {
      draw_text_apart(all, "same text", at, 0.4, texts);
      cv::Mat one = blank.clone();
      std::vector<cv::Rect> none;
      draw_text_apart(one, "same text", at, 0.4, none);
      each_alone += marked(one);
    }
    EXPECT_EQ(marked(all), each_alone);
    for (const cv::Rect& text : texts) EXPECT_EQ(text & cv::Rect({}, all.size()), text);
  }
}

}  // namespace
}  // namespace ballservo
