// Colours taught, merged and shown, as a user's shell sees it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/calibration/color_pictures.hpp"
#include "tests/program/csv_rows.hpp"
#include "tests/program/program_run.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using test::Ending;
using testing::HasSubstr;
using ColorCommands = test::ProgramTest;
namespace fs = std::filesystem;

TEST_F(ColorCommands, ColorsAreTaughtMergedAndShown) {
  const auto put_ball = [&](const std::string& name, const cv::Scalar& color, cv::Point at) {
    cv::Mat picture(120, 160, CV_8UC3, cv::Scalar::all(128));
    cv::circle(picture, at, 22, color, cv::FILLED, cv::LINE_AA);
    cv::imwrite((dir / name).string(), picture);
  };
  put_ball("red.png", {30, 30, 200}, {60, 60});
  put_ball("blue.png", {200, 60, 30}, {90, 50});
  fs::create_directory(dir / "live");
  for (int i = 0; i < 12; ++i) {
    put_ball("live/" + std::to_string(i) + ".png", {40, 180, 40}, {60 + 2 * i, 60});
  }
  ASSERT_EQ(run("calibrate colors red.png -o red.colors").code, 0);
  ASSERT_EQ(run("calibrate colors blue.png --add red.colors -o two.colors").code, 0);
  const Ending taught = run(
      "calibrate colors --from live --box green=60,60,24 --add two.colors -o all.colors --preview preview");
  ASSERT_EQ(taught.code, 0) << taught.messages;
  EXPECT_THAT(taught.out, HasSubstr("green: 12 balls"));
  EXPECT_TRUE(fs::exists(dir / "preview"));
  const Ending shown = run("calibrate colors --show all.colors --json all.json");
  EXPECT_EQ(shown.code, 0);
  for (const char* name : {"red: ", "blue: ", "green: "}) EXPECT_THAT(shown.out, HasSubstr(name));
  EXPECT_THAT(contents("all.json"), HasSubstr("\"background_fraction\""));
  // The same colour under a second name, a box where no ball is, and an option alone.
  EXPECT_EQ(run("calibrate colors --class a=red.png --add red.colors -o no.colors").code, 1);
  EXPECT_EQ(run("calibrate colors --from live --box green=20,100,12 -o no.colors").code, 1);
  EXPECT_EQ(run("calibrate colors --from live -o no.colors").code, 2);
  EXPECT_EQ(run("calibrate colors -o no.colors").code, 2);
  EXPECT_THAT(run("calibrate colors camera:0 -o no.colors").messages,
              HasSubstr("what moves by --from and --box"));
  EXPECT_EQ(run("calibrate colors red.png --background ./red.png -o no.colors").code, 2);
  const Ending rowless = run("detect blue.png --colors red.colors -o no.csv");
  EXPECT_THAT(rowless.messages, HasSubstr("no.csv is not written; to see why"));
  const cv::Mat grey = cv::imread((dir / "red.png").string(), cv::IMREAD_GRAYSCALE);
  ASSERT_TRUE(cv::imwrite((dir / "grey.png").string(), grey));
  for (const std::string command : {"detect", "track"})
    EXPECT_THAT(run(command + " grey.png --colors red.colors").messages, HasSubstr("; all is grey there"));
  EXPECT_FALSE(fs::exists(dir / "no.colors"));
}

// A rough wall as green as the ball's table takes, with a ball before it; and the wall alone.
TEST_F(ColorCommands, ABallBeforeAGroundOfItsColorIsFound) {
  const Eigen::Vector3d pale = 0.5 * test::green_paint + 0.5 * Eigen::Vector3d::Constant(0.2);
  cv::Mat taught(240, 320, CV_8UC3, cv::Scalar::all(140)), wall = taught.clone();
  for (int v = 0; v < wall.rows; ++v) {
    for (int u = 0; u < wall.cols; ++u) {
      const double strength = 0.3 + 0.1 * ((u / 4 * 7 + v / 4 * 11 + u / 4 * (v / 4)) % 10);
      for (int k = 0; k < 3; ++k)
        wall.at<cv::Vec3b>(v, u)[k] = cv::saturate_cast<uchar>(test::srgb_from_linear(strength * pale[k]));
    }
  }
  cv::Mat scene = wall.clone();
  test::draw_shaded_ball(taught, 160, 120, 45, test::green_paint);
  test::draw_shaded_ball(scene, 200, 110, 12, test::green_paint);
  for (auto [name, picture] : {std::pair("taught.png", taught), {"wall.png", wall}, {"scene.png", scene}}) {
    cv::GaussianBlur(picture, picture, {}, 0.7);
    test::add_noise(picture, 1.5, 7);
    cv::imwrite((dir / name).string(), picture);
  }
  ASSERT_EQ(run("calibrate colors --class ball=taught.png -o ball.colors").code, 0);
  EXPECT_EQ(run("detect wall.png --colors ball.colors -o none.csv").code, 1);
  const Ending found = run("detect scene.png --colors ball.colors -o found.csv");
  ASSERT_EQ(found.code, 0) << found.messages;
  EXPECT_THAT(found.messages, testing::Not(HasSubstr("light"))) << "it is the taught one";
  const auto rows = test::read_csv(dir / "found.csv");
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(test::number(rows[0], "cx_px"), 200, 0.3);
  EXPECT_NEAR(test::number(rows[0], "cy_px"), 110, 0.3);
  EXPECT_NEAR(test::number(rows[0], "r_px"), 12, 0.4);
}

TEST_F(ColorCommands, WhatDetectDoesNotSeeIsWarnedOfWhereItTeaches) {
  cv::Mat bgr(240, 320, CV_8UC3, cv::Scalar::all(140));
  test::draw_shaded_ball(bgr, 80, 120, 30, test::green_paint);
  cv::rectangle(bgr, {200, 90, 60, 60}, {40, 40, 200}, cv::FILLED);
  test::add_noise(bgr, 1.5, 7);
  cv::imwrite((dir / "two.png").string(), bgr);
  const auto said = [&](const std::string& at) {
    return run("calibrate colors --class it=two.png --at it=" + at + " -o it.colors --force").messages;
  };
  EXPECT_THAT(said("230,120,25"),
              HasSubstr("detect does not see the it ball around (230, 120) px in two.png"));
  EXPECT_THAT(said("80,120,30"), testing::Not(HasSubstr("detect does not see")));
}

// Where some of several balls are seen yet, as in a quarter of the taught light, they tell it.
TEST_F(ColorCommands, BallsThatAgreeAboutTheLightShowTheOthers) {
  const auto folder = test::opencv_doc_dir();
  if (!folder) GTEST_SKIP() << "opencv-doc is not installed";
  cv::Mat picture = cv::imread((*folder / "smarties.png").string());
  cv::imwrite((dir / "sweets.png").string(), picture);
  cv::imwrite((dir / "dim.png").string(), picture * std::pow(0.25, 1 / 2.2));
  ASSERT_EQ(run("calibrate colors sweets.png -o my.colors").code, 0);
  const auto rows_of = [&](const std::string& name, bool in_another_light) {
    const Ending found = run("detect " + name + " --colors my.colors -o rows.csv --force");
    EXPECT_EQ(found.messages.find("another light") != std::string::npos, in_another_light) << found.messages;
    return test::read_csv(dir / "rows.csv");
  };
  const auto taught = rows_of("sweets.png", false), dim = rows_of("dim.png", true);
  ASSERT_EQ(taught.size(), 11u);
  ASSERT_EQ(dim.size(), 11u);
  for (const test::Row& row : dim)
    EXPECT_TRUE(std::any_of(taught.begin(), taught.end(),
                            [&](const test::Row& same) {
                              return same.at("class") == row.at("class") &&
                                     std::abs(test::number(same, "cx_px") - test::number(row, "cx_px")) < 1 &&
                                     std::abs(test::number(same, "cy_px") - test::number(row, "cy_px")) < 1;
                            }))
        << row.at("class") << " at " << row.at("cx_px") << ", " << row.at("cy_px");
}

}  // namespace
}  // namespace ballservo
