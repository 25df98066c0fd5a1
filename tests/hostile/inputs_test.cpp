// Files, values and limits at their edges: what is refused is named, what is harmless is read.
#include <unistd.h>

#include "calibration/base/csv_table.hpp"
#include "tests/hostile/commands.hpp"

namespace ballservo {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class Inputs : public test::Hostile {
 protected:
  Inputs() {
    const std::filesystem::path data = test::project_data_dir().lexically_normal();
    for (const char* of : {"cameras/wide.yaml", "colors/red.colors"})
      std::filesystem::copy_file(data / of, dir / std::filesystem::path(of).filename());
    std::ifstream stream(data / "scenarios/static_ball.yaml");
    const std::string text = (std::stringstream() << stream.rdbuf()).str();
    put("s.yaml", std::regex_replace(text.substr(0, text.find("vary:")), std::regex(R"(\.\./[a-z]*/)"), ""));
  }
  void put_big_camera(int width_px, int height_px) const {
    const std::string sized = std::regex_replace(contents("wide.yaml"), std::regex("width: [0-9]+"),
                                                 "width: " + std::to_string(width_px));
    put("wide.yaml",
        std::regex_replace(sized, std::regex("height: [0-9]+"), "height: " + std::to_string(height_px)));
  }
};

TEST_F(Inputs, TextOfAnyEditorIsRead) {
  put("kalibr.yaml",
      "cam0:\n  camera_model: pinhole\n  intrinsics: [480, 480, 319.5, 239.5]\n  distortion_model: radtan\n"
      "  distortion_coeffs: [-0.1, 0.01, 0, 0]\n  resolution: [640, 480]\n");
  put("marked.yaml", "\xef\xbb\xbf" + contents("kalibr.yaml"));
  EXPECT_EQ(run("calibrate diff kalibr.yaml marked.yaml").code, 0);
  put("windows.colors",
      "\xef\xbb\xbf" + std::regex_replace(contents("red.colors"), std::regex("\n"), "\r\n"));
  EXPECT_EQ(run("calibrate colors --show windows.colors").code, 0);
}

TEST_F(Inputs, AJpegThatPromisesMoreThanItHoldsIsRefusedInOurWordsAlone) {
  cv::Mat noise(64, 64, CV_8UC3);
  cv::randu(noise, 0, 255);
  cv::imwrite((dir / "noise.jpg").string(), noise);
  const std::string detect = "detect noise.jpg --colors red.colors";
  EXPECT_EQ(run(detect).code, 1);
  std::string bytes = contents("noise.jpg");
  const std::size_t frame = bytes.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  bytes[frame + 6] = '\x7f';  // of the height's two bytes
  put("noise.jpg", bytes);
  const auto ending = run(detect);
  EXPECT_EQ(ending.code, 2);
  EXPECT_EQ(
      ending.messages,
      "ballservo: error: noise.jpg: found a truncated picture; allowed: a whole PNG, JPEG, BMP, PNM, TIFF or "
      "WebP picture\n");
}

TEST_F(Inputs, LibrariesSayNothingOnStderr) {
#if !defined(NDEBUG) || defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "what debugs or checks the program may speak there";
#endif
  cv::Mat noise(64, 64, CV_8UC3);
  cv::randu(noise, 0, 255);
  cv::imwrite((dir / "noise.png").string(), noise);
  std::string bytes = contents("noise.png");
  bytes[bytes.size() / 2] ^= 0x55;  // libpng has its own words for a wrong checksum
  put("noise.png", bytes);
  EXPECT_THAT(run("detect noise.png --colors red.colors").messages,
              testing::StartsWith("ballservo: error: noise.png"));
}

TEST_F(Inputs, NamesThatNoFileCanHaveAreSaid) {
  const std::string name(300, 'x');
  for (const std::string command : {"report ", "sweep merge other -o out ", "compare merge other -o out "}) {
    const auto ending = run(command + name);
    EXPECT_EQ(ending.code, 2) << command;
    EXPECT_THAT(ending.messages, HasSubstr("File name too long; allowed: ")) << command;
  }
}

TEST_F(Inputs, AFolderThatCannotBeReadIsNotCalledEmpty) {
  std::filesystem::create_directories(dir / "locked");
  std::filesystem::permissions(dir / "locked", std::filesystem::perms::owner_exec);
  std::filesystem::permissions(dir, std::filesystem::perms::all);
  // Root may read all: then as nobody.
  const std::string nobody = ::geteuid() == 0 ? "setpriv --reuid 65534 --regid 65534 --clear-groups" : "";
  EXPECT_THAT(run("detect locked --colors red.colors", nobody).messages,
              HasSubstr("locked: found Permission denied"));
  std::filesystem::permissions(dir / "locked", std::filesystem::perms::owner_all);
}

TEST_F(Inputs, AValueIsNamedAsItWasGiven) {
  for (const char* empty : {"render s.yaml -o out --frames ''", "render s.yaml -o out --seed ' '",
                            "sweep s.yaml --trials 1 -o out --shard ''"}) {
    EXPECT_THAT(run(empty).messages, ContainsRegex("found \" ?\";")) << empty;
  }
  EXPECT_EQ(run("sweep s.yaml --trials 1 -o out --against ''").code, 2);
  EXPECT_THAT(run("render s.yaml -o out --seed 9223372036854775807").messages,
              HasSubstr("a whole number from 0 to 1000000000000000000"));
}

TEST_F(Inputs, AFaultOfADrawnValueIsThatOfItsEntry) {
  const std::string scenario = contents("s.yaml");
  const auto line = std::count(scenario.begin(), scenario.end(), '\n') + 2;
  for (const char* key : {"nokey.x", "balls.0.diameter_m", "balls.9.x"}) {
    put("v.yaml", scenario + "vary:\n  " + key + ": {uniform: [-2, -1]}\n");
    EXPECT_THAT(run("render v.yaml -o out").messages,
                HasSubstr("v.yaml:" + std::to_string(line) + ": vary." + key + ": found"));
  }
  EXPECT_THAT(run("render s.yaml -o out --set nokey.x=1").messages, HasSubstr("--set: nokey"));
}

TEST_F(Inputs, WorldsThatCannotBeAreSaidToTellNothing) {
  const auto ending = run(
      "sweep s.yaml --trials 1 --perception truth -o out --set 'obstacles=[{type: box, size: {x_m: 0.2, y_m: "
      "4.9, z_m: 1}, position: {x_m: 1.5, y_m: 0}}]'");
  EXPECT_EQ(ending.code, 0);
  EXPECT_THAT(ending.messages + ending.out, Not(HasSubstr("nan")));
}

TEST_F(Inputs, PicturesThatDoNotFitAreRefusedBeforeTheWork) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer takes all the addresses there are";
#endif
  put("plan.yaml",
      "frames: 1\nmethods: [vote]\ndefaults: {camera: {file: wide.yaml}}\nconditions: [{name: a}]\n");
  const std::vector<std::string> all{
      "servo s.yaml -o out",      "servo s.yaml --teach -o out",
      "render s.yaml -o out",     "sweep s.yaml --trials 1 --perception image -o out",
      "compare plan.yaml -o out", "detect s.yaml --colors red.colors --camera wide.yaml"};
  put_big_camera(6000, 5000);
  for (const std::string& command : all) {
    const auto large = run(command + " --threads 1", "bash -c 'ulimit -v 2500000; exec \"$0\" \"$@\"'");
    EXPECT_EQ(large.code, 2) << command;
    EXPECT_THAT(large.messages, HasSubstr("2.7 GB of memory; allowed: ")) << command;
  }
  put_big_camera(9000, 9000);
  for (const std::string& command : all)
    EXPECT_THAT(run(command).messages, HasSubstr("found 9000 x 9000 pixels; allowed: at most 32000000"))
        << command;
}

TEST(CsvCells, AreNoFormulasAndReadBackAsTheyWere) {
  for (const std::string text :
       {"=1+1", "+x", "-x", "@SUM(A1)", "'=1", "''=1", "it's", "'", "-1.5", "=a,\"b\""}) {
    const std::string cell = csv_cell(text);
    EXPECT_EQ(parse_csv("a,b\n" + cell + ",\n", "t.csv", {"a", "b"}).rows[0][0], text);
    const char first = cell[cell[0] == '"' ? 1 : 0];
    EXPECT_TRUE(text == "-1.5" || std::string("=+-@").find(first) == std::string::npos) << cell;
  }
}

}  // namespace
}  // namespace ballservo
