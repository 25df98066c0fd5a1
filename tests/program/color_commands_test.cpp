// Colours taught, merged and shown, as a user's shell sees it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <string>

#include "tests/program/program_run.hpp"

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
  EXPECT_FALSE(fs::exists(dir / "no.colors"));
}

}  // namespace
}  // namespace ballservo
