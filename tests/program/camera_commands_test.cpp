// calibrate diff and calibrate radius as a user's shell sees them.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "calibration/color/color_file.hpp"
#include "tests/perception/painted_ball.hpp"
#include "tests/program/program_run.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using CameraCommands = test::ProgramTest;

constexpr const char* pinhole_text =
    "cam0:\n  camera_model: pinhole\n  intrinsics: [{}, {}, 319.5, 239.5]\n  distortion_model: none\n"
    "  distortion_coeffs: []\n  resolution: [{}, 480]\n  rostopic: /cam0/image_raw\n";

std::string camera_text(double focal_px, int width_px = 640) {
  return fmt::format(fmt::runtime(pinhole_text), focal_px, focal_px, width_px);
}

TEST_F(CameraCommands, DifferencesInPixelsAndMillimetres) {
  pages_drawn = true;
  put("a.yaml", camera_text(600.5));
  put("b.yaml", camera_text(606.505));
  const auto ending = run("calibrate diff a.yaml b.yaml:cam0 --range 2 --json d.json --report page");
  EXPECT_EQ(ending.code, 0) << ending.messages;
  EXPECT_THAT(ending.out, HasSubstr(", at most 19.99"));
  EXPECT_THAT(ending.out, HasSubstr("is not known"));
  const auto json = nlohmann::json::parse(contents("d.json"));
  EXPECT_NEAR(json["ball_difference_max_mm"].get<double>(), 20, 0.05);
  EXPECT_LT(json["rotation_angle_rad"].get<double>(), 1e-6);
  EXPECT_TRUE(json["within_uncertainties"].is_null());
  EXPECT_EQ(json["places"].size(), 25u * 19u);
  EXPECT_THAT(contents("page/report.html"), HasSubstr("<svg"));
  EXPECT_EQ(run("calibrate diff a.yaml b.yaml --report page").code, 2) << "an output that exists";
}

TEST_F(CameraCommands, WhatCannotBeCompared) {
  put("a.yaml", camera_text(600));
  put("wide.yaml", camera_text(600, 800));
  for (const char* arguments :
       {"a.yaml wide.yaml", "a.yaml missing.yaml", "a.yaml", "a.yaml a.yaml --range nan",
        "a.yaml a.yaml --diameter 0", "a.yaml a.yaml --diameter 3 --range 1", "a.yaml a.yaml:cam1"}) {
    const auto ending = run(std::string("calibrate diff ") + arguments + " --json d.json");
    EXPECT_EQ(ending.code, 2) << arguments;
    EXPECT_THAT(ending.messages, HasSubstr("error: ")) << arguments;
    EXPECT_THAT(ending.out, IsEmpty());
  }
  EXPECT_THAT(run("calibrate diff a.yaml wide.yaml").messages,
              HasSubstr("wide.yaml: found a camera of 800 x 480"));
  EXPECT_THAT(run("calibrate diff a.yaml a.yaml@0x0").messages, HasSubstr("found the size '0x0'"));
  EXPECT_EQ(names().count("d.json"), 0u);
  EXPECT_EQ(run("calibrate diff a.yaml a.yaml:cam0 --json a.yaml --force").code, 2);
  EXPECT_EQ(contents("a.yaml"), camera_text(600));
}

class RadiusCommand : public CameraCommands {
 protected:
  void SetUp() override {
    put("camera.yaml", camera_text(600));
    put("my.colors", color_file_bytes(*test::red_and_green()));
    for (const double distance_m : {0.8, 1.0, 1.2})
      paint_ball(fmt::format("at_{}.png", distance_m), distance_m, test::red);
  }
  void paint_ball(const std::string& name, double distance_m, const cv::Vec3b& color,
                  std::optional<cv::Vec3b> beside = {}) const {
    cv::Mat bgr = test::grey_picture(640, 480);
    const double radius_px = 600 * 0.035 / std::sqrt(distance_m * distance_m - 0.035 * 0.035);
    test::paint_disc(bgr, {319.5, 239.5}, radius_px, color);
    if (beside) test::paint_disc(bgr, {419.5, 239.5}, radius_px, *beside);
    cv::imwrite((dir / name).string(), bgr);
  }
  std::string table(double last_m) const {
    return fmt::format("source,distance_m\nat_0.8.png,0.8\nat_1.png,1.0\nat_1.2.png,{}\n", last_m);
  }
  const std::string radius =
      "calibrate radius at_0.8.png at_1.png at_1.2.png --colors my.colors --camera camera.yaml ";
};

TEST_F(RadiusCommand, DiameterWithItsSigma) {
  put("tape.csv", table(1.2));
  const auto ending = run(radius + "--distances tape.csv --json r.json");
  EXPECT_EQ(ending.code, 0) << ending.messages;
  EXPECT_THAT(ending.out, HasSubstr("--diameter 0.0"));
  const auto json = nlohmann::json::parse(contents("r.json"));
  EXPECT_EQ(json["used"], 3);
  EXPECT_LT(json["sigma_m"].get<double>(), 0.0002);
  EXPECT_NEAR(json["diameter_m"].get<double>(), 0.07, 4 * json["sigma_m"].get<double>());
  EXPECT_EQ(json["pictures"][2]["source"], "at_1.2.png");
}

TEST_F(RadiusCommand, OneBallInMetres) {
  paint_ball("at_1.2.png", 1.2, test::green);
  put("tape.csv", table(1.2));
  const auto mixed = run(radius + "--distances tape.csv");
  EXPECT_EQ(mixed.code, 2);
  EXPECT_THAT(mixed.messages, HasSubstr("at_0.8.png shows the ball red, at_1.2.png the ball green"));
  EXPECT_EQ(run(radius + "--distances tape.csv --class red").code, 0);
  put("in_cm.csv", "source,distance_m\nat_0.8.png,80\nat_1.png,100\nat_1.2.png,120\n");
  EXPECT_THAT(run(radius + "--distances in_cm.csv --class red").messages, HasSubstr("a ball of 7.0"));
}

TEST_F(RadiusCommand, OfSeveralBallsAClassSaysWhichWhereItCan) {
  put("tape.csv", table(1.2));
  paint_ball("at_1.png", 1, test::red, test::green);
  EXPECT_THAT(run(radius + "--distances tape.csv").out,
              HasSubstr("at_1.png: not used, several balls in it (red, green): --class NAME"));
  paint_ball("at_1.png", 1, test::red, test::red);
  for (const char* wanted : {"", " --class red"})
    EXPECT_THAT(run(radius + "--distances tape.csv" + wanted).out,
                HasSubstr("at_1.png: not used, several balls in it (red, red): leave the one"));
}

TEST_F(RadiusCommand, ContradictionsAndBadTables) {
  put("tape.csv", table(1.4));
  put("tape2.csv", "source,distance_m\nat_0.8.png,0.8\nat_1.png,1.3\nat_1.2.png,1.2\n");
  const std::set<std::string> before = names();
  for (const char* file : {"tape.csv", "tape2.csv"}) {
    const auto ending = run(radius + "--json r.json --distances " + file);
    EXPECT_EQ(ending.code, 1) << file;
    EXPECT_THAT(ending.messages, HasSubstr("contradict"));
    EXPECT_THAT(ending.messages, HasSubstr("at_1.png: diameter 0.0"));
  }
  EXPECT_EQ(names(), before);
  const auto one =
      run("calibrate radius at_1.png --colors my.colors --camera camera.yaml --distances tape.csv");
  EXPECT_EQ(one.code, 0);
  EXPECT_THAT(one.out, HasSubstr("nothing confirms it"));
  const auto no_board =
      run("calibrate radius at_1.png --colors my.colors --camera camera.yaml --board chessboard:9x6 --square "
          "0.02");
  EXPECT_EQ(no_board.code, 1);
  EXPECT_THAT(no_board.messages, HasSubstr("at_1.png: the board was not found"));
  put("bad.csv", "source,distance_m\nat_0.8.png,-0.8\nat_0.8.png,1,2\nat_1.png,nan\n");
  put("short.csv", "source,distance_m\nat_0.8.png,0.8\n");
  for (const char* arguments :
       {"", "--distances bad.csv", "--distances short.csv", "--distances missing.csv",
        "--distances tape.csv --board chessboard:9x6 --square 0.02", "--board chessboard:9x6",
        "--distances tape.csv --class blue", "--distances tape.csv --json tape.csv --force"})
    EXPECT_EQ(run(radius + arguments).code, 2) << arguments;
  EXPECT_THAT(run(radius + "--distances short.csv").messages, HasSubstr("no row for at_1.2.png"));
}

}  // namespace
}  // namespace ballservo
