#include <gtest/gtest.h>

#include <map>
#include <opencv2/imgproc.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "calibration/teaching/class_report.hpp"
#include "calibration/teaching/class_table.hpp"
#include "calibration/teaching/color_samples.hpp"
#include "calibration/teaching/learn_colors.hpp"
#include "calibration/teaching/merge_colors.hpp"
#include "tests/calibration/color_pictures.hpp"

namespace ballservo {
namespace {

using namespace test;

ColorPicture ball_picture(const Eigen::Vector3d& paint, double strength = 1, std::uint64_t seed = 1) {
  cv::Mat picture = grey_picture();
  draw_shaded_ball(picture, 160, 120, 45, strength * paint);
  add_noise(picture, 2, seed);
  return {"ball.png", picture};
}

/// The same picture teaches the same, so that it need be learnt from only once.
ColorTable taught(const std::string& name, const ColorPicture& picture) {
  static std::map<double, ColorTable> known;
  ColorTable& colors = known[cv::norm(picture.bgr)];
  if (colors.classes.empty()) colors = learn_colors({picture}).table;
  ColorTable result = colors;
  result.classes.at(0).name = name;
  return result;
}

/// The part of the ball's pixels that are of the class.
double found(const ColorTable& colors, const std::string& name, const ColorPicture& picture) {
  int all = 0, of_class = 0;
  for (int y = 80; y < 160; ++y) {
    for (int x = 120; x < 200; ++x) {
      if (std::hypot(x - 160, y - 120) > 40) continue;
      const cv::Vec3b& c = picture.bgr.at<cv::Vec3b>(y, x);
      ++all;
      of_class += colors.classify(c[0], c[1], c[2]) == colors.find(name).value_or(200) ? 1 : 0;
    }
  }
  return static_cast<double>(of_class) / all;
}

TEST(MergeColors, AFileAloneStaysAsItIs) {
  const ColorTable red = taught("red", ball_picture(red_paint));
  EXPECT_EQ(color_file_bytes(merge_colors({red})), color_file_bytes(red));
}

TEST(MergeColors, DifferentClassesJoinInAnyOrder) {
  const ColorTable red = taught("red", ball_picture(red_paint)),
                   blue = taught("blue", ball_picture(blue_paint));
  for (const ColorTable& both : {merge_colors({red, blue}), merge_colors({blue, red})}) {
    ASSERT_EQ(both.classes.size(), 2u);
    EXPECT_GT(found(both, "red", ball_picture(red_paint, 1, 5)), 0.95);
    EXPECT_GT(found(both, "blue", ball_picture(blue_paint, 1, 5)), 0.95);
    EXPECT_TRUE(judge_classes(both, report_classes(both)).refusals.empty());
  }
}

TEST(MergeColors, ClassesOfOneNameAreUnited) {
  const ColorPicture day = ball_picture(red_paint), evening = ball_picture(red_paint, 0.12);
  const ColorTable by_day = taught("red", day), by_evening = taught("red", evening);
  const ColorTable both = merge_colors({by_day, by_evening});
  ASSERT_EQ(both.classes.size(), 1u);
  EXPECT_EQ(both.classes[0].samples, by_day.classes[0].samples + by_evening.classes[0].samples);
  EXPECT_GT(found(both, "red", day), 0.95);
  EXPECT_GT(found(both, "red", evening), found(by_day, "red", evening) + 0.1);
}

TEST(MergeColors, DifferentColorsOfOneNameAreRefused) {
  EXPECT_THROW(
      merge_colors({taught("ball", ball_picture(red_paint)), taught("ball", ball_picture(blue_paint))}),
      Refusal);
}

TEST(MergeColors, APictureDoesNotDrownInAVideo) {
  const ColorPicture day = ball_picture(red_paint), evening = ball_picture(red_paint, 0.12);
  ColorTable video = taught("red", day);
  for (std::uint32_t& count : video.classes[0].histogram.counts) count *= 50;
  for (CellCount& cell : video.classes[0].cells) cell.count *= 50;
  video.classes[0].samples *= 50;
  const ColorTable picture = taught("red", evening);
  const double alone = found(merge_colors({taught("red", day), picture}), "red", evening);
  EXPECT_GT(found(merge_colors({video, picture}), "red", evening), alone - 0.1);
}

TEST(MergeColors, WhatIsWrittenAndReadMergesTheSame) {
  const ColorTable red = taught("red", ball_picture(red_paint)),
                   green = taught("green", ball_picture(green_paint));
  const ColorTable again = parse_color_file(color_file_bytes(red), "red.colors");
  EXPECT_EQ(color_file_bytes(merge_colors({again, green})), color_file_bytes(merge_colors({red, green})));
}

TEST(MergeColors, TooManyClassesAreRefused) {
  const ColorTable red = taught("red", ball_picture(red_paint));
  std::vector<ColorTable> tables;
  for (int i = 0; i <= max_classes; ++i) {
    tables.push_back(red);
    tables.back().classes[0].name = "red_" + std::to_string(i);
  }
  EXPECT_THROW(merge_colors(tables), Refusal);
  tables.pop_back();
  EXPECT_EQ(merge_colors(tables).classes.size(), static_cast<std::size_t>(max_classes));
}

TEST(MergeColors, SettingsStayWhereAllAgree) {
  ColorTable a = taught("red", ball_picture(red_paint)), b = a;
  a.camera_settings = {{"exposure", 100}, {"gain", 1}};
  b.camera_settings = {{"exposure", 100}, {"gain", 2}};
  EXPECT_EQ(merge_colors({a, b}).camera_settings, (std::map<std::string, double>{{"exposure", 100}}));
  b.camera_settings.clear();
  EXPECT_TRUE(merge_colors({a, b}).camera_settings.empty());
}

TEST(MergeColors, APictureOfAKnownBallTakesItsName) {
  const ColorTable target = taught("target", ball_picture(red_paint));
  const LearntColors more = learn_colors({ball_picture(red_paint, 0.8, 4)});
  EXPECT_EQ(names_to_join(more.table, target), std::vector<std::string>{"target"});
  const LearntColors other = learn_colors({ball_picture(blue_paint)});
  EXPECT_EQ(names_to_join(other.table, target), std::vector<std::string>{"blue"});
  ColorTable taken = target;
  taken.classes[0].name = "blue";
  EXPECT_EQ(names_to_join(other.table, taken), std::vector<std::string>{"blue_2"});
}

TEST(ClassReport, TwoClassesOfOneColorAreRefused) {
  const ColorTable twice =
      merge_colors({taught("red", ball_picture(red_paint)), taught("target", ball_picture(red_paint, 1, 9))});
  const ClassFindings findings = judge_classes(twice, report_classes(twice));
  ASSERT_EQ(findings.refusals.size(), 1u);
  EXPECT_NE(findings.refusals[0].find("red and target were taught the same colour"), std::string::npos);
}

TEST(ClassReport, AClassOfTheWallIsRefused) {
  cv::Mat wall(240, 320, CV_8UC3, cv::Scalar(60, 110, 150));
  draw_shaded_ball(wall, 80, 60, 30, blue_paint);
  add_noise(wall, 2, 3);
  const LearntColors colors =
      learn_classes({{"wall.png", wall}}, {{"ball", {0}, PointedBall{{220, 150}, 40}}});
  EXPECT_EQ(judge_classes(colors.table, report_classes(colors.table)).refusals.size(), 1u);
  const LearntColors ball = learn_classes({{"wall.png", wall}}, {{"ball", {0}, PointedBall{{80, 60}, 30}}});
  EXPECT_TRUE(judge_classes(ball.table, report_classes(ball.table)).refusals.empty());
}

TEST(ClassReport, TheLightThatItSaysIsSurvivedIsSurvived) {
  const ColorTable colors = taught("red", ball_picture(red_paint));
  const ClassReport report = report_classes(colors)[0];
  EXPECT_LT(report.light.level_low, 0.7);
  EXPECT_GT(report.light.level_high, 1.2);
  EXPECT_LT(report.light.warmest_k, 5500);
  EXPECT_GT(report.light.coolest_k, 7500);
  EXPECT_GT(report.light.warmer_mired, 0);
  EXPECT_LT(report.dissolves_at_chroma, report.chroma);
  EXPECT_GT(report.dissolves_at_chroma, 4);
  EXPECT_GT(found(colors, "red", ball_picture(red_paint, 1.15 * report.light.level_low)), 0.45);
  EXPECT_LT(found(colors, "red", ball_picture(red_paint, 0.6 * report.light.level_low)), 0.5);
}

// A ball before a wall of its colour, as pale as the ball's table still takes.
TEST(OwnGround, IsLeftOutOfTheTable) {
  const ColorTable green = taught("green", ball_picture(green_paint));
  const Eigen::Vector3d pale = 0.6 * green_paint + 0.4 * Eigen::Vector3d::Constant(0.2);
  cv::Mat scene = grey_picture();
  scene = cv::Scalar(srgb_from_linear(pale[0]), srgb_from_linear(pale[1]), srgb_from_linear(pale[2]));
  draw_shaded_ball(scene, 160, 120, 45, green_paint);
  add_noise(scene, 2, 3);
  const auto share_of_wall = [&](const ColorTable& colors) {
    CellCounts counts;
    count_cells(scene(cv::Rect(0, 0, 320, 70)), {}, counts);
    return 1 - pixels_of_classes(occupied(counts), colors)[no_class] / (320 * 70);
  };
  EXPECT_GT(share_of_wall(green), 0.9);
  const auto before = before_own_ground(green, scene);
  ASSERT_TRUE(before);
  EXPECT_LT(share_of_wall(*before), 0.02);
  EXPECT_GT(found(*before, "green", {"scene", scene}), 0.8);
}

TEST(OwnGround, IsOneOnlyWhereItHasTheColorsAndTheirCellsAreKnown) {
  ColorTable green = taught("green", ball_picture(green_paint));
  EXPECT_FALSE(before_own_ground(green, grey_picture()));
  const cv::Mat leaf(240, 320, CV_8UC3, cv::Scalar(80, 180, 70));
  EXPECT_TRUE(before_own_ground(green, leaf));
  green.classes[0].cells.clear();
  EXPECT_FALSE(before_own_ground(green, leaf));
}

}  // namespace
}  // namespace ballservo
