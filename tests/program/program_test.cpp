// How the program ends: exit codes, messages and outputs, as a user's shell sees them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>

#include "app/io/video_writer.hpp"
#include "tests/program/program_run.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;

using Program = test::ProgramTest;
using test::Ending;

TEST_F(Program, SaysItsVersionOnOneLine) {
  const Ending ending = run("--version");
  EXPECT_EQ(ending.code, 0);
  EXPECT_THAT(ending.out, MatchesRegex("ballservo [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  EXPECT_THAT(ending.messages, IsEmpty());
}

TEST_F(Program, EveryCommandHelpsWithAnExample) {
  EXPECT_EQ(run("--help").code, 0);
  for (const char* command : {"calibrate board", "calibrate camera", "calibrate diff", "calibrate radius",
                              "calibrate colors", "detect", "track", "render", "servo", "compare"}) {
    const Ending ending = run(std::string(command) + " --help");
    EXPECT_EQ(ending.code, 0) << command;
    EXPECT_THAT(ending.out, HasSubstr("xample")) << command;
    EXPECT_THAT(ending.out, HasSubstr("ballservo " + std::string(command))) << command;
    EXPECT_THAT(ending.messages, IsEmpty()) << command;
  }
}

TEST_F(Program, BadUsageEndsWithTwoAndAMessage) {
  for (const char* arguments :
       {"", "nonsense", "--nonsense", "calibrate", "calibrate camera", "detect", "detect --nonsense", "servo",
        "render", "compare", "track", "detect a.png --colors x --threads 1.5",
        "detect a.png --colors x --threads 0x2", "detect a.png --colors x --max-pixels nan",
        "servo a.yaml -o b --seed -1"}) {
    const Ending ending = run(arguments);
    EXPECT_EQ(ending.code, 2) << arguments;
    EXPECT_THAT(ending.out, IsEmpty()) << arguments;
    EXPECT_THAT(ending.messages, HasSubstr("ballservo: error: ")) << arguments;
  }
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(Program, BadPicturesAreAllNamedAndNothingIsWritten) {
  put_grey_picture("good.png");
  put("empty.png", "");
  put("text.png", "no picture\n");
  const std::string whole = contents("good.png");
  put("cut.png", whole.substr(0, whole.size() / 2));
  const std::set<std::string> before = names();
  for (const char* command :
       {"calibrate camera missing.png empty.png text.png good.png --board chessboard:9x6 "
        "--square 0.025 -o camera.yaml --json results.json",
        "calibrate colors missing.png empty.png text.png good.png -o my.colors --json results.json"}) {
    const Ending ending = run(command);
    EXPECT_EQ(ending.code, 2) << command;
    for (const char* file : {"missing.png", "empty.png", "text.png"}) {
      EXPECT_THAT(ending.messages, HasSubstr(std::string("error: ") + file + ": found ")) << command;
    }
  }
  EXPECT_EQ(run("calibrate colors cut.png -o my.colors").code, 2);
  EXPECT_EQ(run("calibrate colors good.png -o my.colors --max-pixels 100").code, 2);
  EXPECT_EQ(names(), before);
}

TEST_F(Program, AnswerNoEndsWithOneAndLeavesNoFile) {
  put_grey_picture("grey.png");
  const std::set<std::string> before = names();
  EXPECT_EQ(run("calibrate camera grey.png --board chessboard:9x6 --square 0.025 -o camera.yaml").code, 1);
  EXPECT_EQ(run("calibrate colors grey.png -o my.colors").code, 1);
  EXPECT_EQ(names(), before);
}

TEST_F(Program, ExistingOutputStaysUnlessForced) {
  put_grey_picture("grey.png");
  put("camera.yaml", "mine");
  const std::string camera = "calibrate camera grey.png --board chessboard:9x6 --square 0.025 ";
  for (const std::string& arguments : {camera + "-o camera.yaml", camera + "-o new.yaml --json camera.yaml",
                                       camera + "-o no/folder.yaml", camera + "-o ."}) {
    EXPECT_EQ(run(arguments).code, 2) << arguments;
  }
  EXPECT_EQ(run(camera + "-o camera.yaml --force").code, 1);
  EXPECT_EQ(contents("camera.yaml"), "mine");
  EXPECT_EQ(names(), (std::set<std::string>{"grey.png", "camera.yaml"}));
}

TEST_F(Program, OutputsThatCannotBeWrittenAreAllNamed) {
  put_grey_picture("grey.png");
  for (const char* name : {"a.csv", "b.mp4", "c.json"}) put(name, "mine");
  const auto faults = [&](const std::string& arguments) {
    const Ending ending = run(arguments);
    EXPECT_EQ(ending.code, 2) << arguments;
    return ending.messages;
  };
  const std::string track =
      faults("track grey.png --colors none -o a.csv --video b.mp4 --json c.json --stages no/d");
  for (const char* name : {"a.csv", "b.mp4", "c.json"})
    EXPECT_THAT(track,
                HasSubstr(std::string("error: ") + name + ": found an existing file; allowed: a new name"));
  EXPECT_THAT(track, HasSubstr("error: no/d: found no folder no;"));
  EXPECT_THAT(faults("servo none.yaml --teach -o a.csv --json c.json"),
              HasSubstr("a.csv: found an existing file"));
  EXPECT_THAT(faults("servo none.yaml --teach -o a.csv --forec"), HasSubstr("did you mean --force?"));
  std::filesystem::create_directory(dir / "sweep");
  put("sweep/a", "");
  for (const char* resume : {"", " --resume"}) {
    const std::string sweep =
        faults(std::string("sweep none.yaml --trials 1 -o sweep --json c.json") + resume);
    EXPECT_THAT(sweep, HasSubstr("c.json: found an existing file"));
    EXPECT_EQ(sweep.find("sweep: found") == std::string::npos, *resume != 0) << sweep;
  }
  put("sweep/unfinished.journal", "");
  EXPECT_THAT(faults("live none.yaml --record sweep"), HasSubstr("sweep: found a folder that is not empty"));
  const std::string live = faults("live none.yaml --colors c --last 2");
  for (const char* option : {"--colors", "--last"})
    EXPECT_THAT(live, HasSubstr(std::string(option) + ": found with a scenario"));
  EXPECT_THAT(live, Not(HasSubstr("--camera")));
}

TEST_F(Program, RangesAreSpokenOfWhereThereAreSome) {
  put_grey_picture("grey.png");
  const std::string colors = (test::project_data_dir() / "colors" / "red.colors").string();
  const std::string detect = "detect grey.png --colors '" + colors + "' --fov 60";
  EXPECT_THAT(run(detect).messages, HasSubstr("--fov without --diameter: no positions in 3-D"));
  EXPECT_THAT(run(detect).messages, testing::Not(HasSubstr("ranges")));
  EXPECT_THAT(run(detect + " --diameter 0.07").messages, HasSubstr("ranges to 14 % (1 sigma)"));
}

TEST_F(Program, FullDiskEndsWithTwoAndLeavesNothing) {
  const std::string scenario = (test::project_data_dir() / "scenarios" / "static_ball.yaml").string();
  // The shell counts in blocks of 512 or 1024 bytes: far less than a picture either way.
  const Ending ending = run("render '" + scenario + "' -o out --frames 1", "ulimit -f 8;");
  EXPECT_EQ(ending.code, 2) << ending.messages;
  EXPECT_THAT(ending.messages, HasSubstr("File too large"));
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(Program, InterruptedRunEndsWith130) {
  const std::string scenario = (test::project_data_dir() / "scenarios" / "static_ball.yaml").string();
  const Ending ending =
      run("render '" + scenario + "' -o out --frames 100000", "timeout --preserve-status -s INT 3");
  EXPECT_EQ(ending.code, 130) << ending.messages;
  for (const std::string& name : names()) EXPECT_THAT(name, testing::Not(HasSubstr("partial")));
}

TEST_F(Program, InterruptedTeachingEndsWith130AndLeavesNothing) {
  const std::string scenario = (test::project_data_dir() / "scenarios" / "static_ball.yaml").string();
  const Ending ending =
      run("servo '" + scenario + "' --teach -o taught.yaml --set camera.exposure_steps=64",  // slow enough
          "timeout --preserve-status -s INT 0.3");
  EXPECT_EQ(ending.code, 130) << ending.messages;
  EXPECT_THAT(names(), IsEmpty());
}

TEST_F(Program, AGoalThatCannotBeReachedIsWarnedOf) {
  const std::string scenario = (test::project_data_dir() / "scenarios" / "static_ball.yaml").string();
  for (const bool near : {true, false}) {
    const std::string goal = near ? "0.8" : "10";  // the room is 8 m by 7 m
    const Ending ending = run("servo '" + scenario + "' --perception geometric --set duration_s=0.1 -o out_" +
                              goal + " --set target.distance_m=" + goal);
    EXPECT_EQ(ending.messages.find("the goal cannot be reached: no way") == std::string::npos, near) << goal;
  }
}

TEST_F(Program, AMisspeltCommandIsNamed) {
  const Ending ending = run("calibarte camera a.png");
  EXPECT_EQ(ending.code, 2);
  EXPECT_THAT(ending.messages, HasSubstr("found calibarte; allowed: calibrate, detect, track"));
  EXPECT_THAT(run("calibrate camrea").messages, HasSubstr("found camrea; allowed: board, camera, diff"));
  for (const char* command : {"colour", "calibrate colour"}) {
    const Ending asked = run(std::string(command) + " --help");
    EXPECT_EQ(asked.code, 2) << command;
    EXPECT_THAT(asked.out, IsEmpty()) << command;
    EXPECT_THAT(asked.messages, HasSubstr("command: found colour; allowed: ")) << command;
  }
}

TEST_F(Program, AMisspeltOptionIsNamedBeforeWhatIsMissing) {
  EXPECT_THAT(run("detect a.png --colours ball.colors").messages,
              HasSubstr("--colours: no such option; did you mean --colors?"));
  EXPECT_THAT(run("render a.yaml -o out --sed 3").messages,
              HasSubstr("--sed: no such option; did you mean --set or --seed?"));
  EXPECT_THAT(run("render a.yaml -o out --seeds=3").messages,
              HasSubstr("--seeds=3: no such option; did you mean --seed?"));
  EXPECT_THAT(run("render a.yaml -o out --sideways").messages, HasSubstr("--sideways: no such option\n"));
  EXPECT_THAT(run("detect a.png --colors c -o --force").messages,
              HasSubstr("--output: found --force; allowed: a value; that is another option"));
  EXPECT_THAT(run("render a.yaml -o out b c").messages, HasSubstr("not expected: b c\n"));
  EXPECT_THAT(run("render a.yaml -o out -o other").messages,
              HasSubstr("--output: found 2 values; allowed: no more than 1\n"));
}

TEST_F(Program, TwoOutputsOfOneNameAreRefused) {
  put_grey_picture("grey.png");
  const Ending ending = run("track grey.png --colors red.colors -o same.csv --json ./same.csv --force");
  EXPECT_EQ(ending.code, 2);
  EXPECT_THAT(ending.messages, HasSubstr("error: --json: found"));
}

TEST_F(Program, PicturesAreNotDrawnOverTheirSources) {
  put_grey_picture("grey.png");
  const std::string before = contents("grey.png");
  for (const char* command :
       {"detect . --overlay .", "detect grey.png --overlay .", "track grey.png --stages ."}) {
    const Ending ending = run(std::string(command) + " --colors red.colors --force");
    EXPECT_EQ(ending.code, 2) << command;
    EXPECT_THAT(ending.messages, HasSubstr("which is read")) << command;
  }
  EXPECT_EQ(contents("grey.png"), before);
}

TEST_F(Program, TrackNamesThePictureOfAnotherSize) {
  put_grey_picture("first.png");
  cv::imwrite((dir / "second.png").string(), cv::Mat(60, 80, CV_8UC3, cv::Scalar::all(128)));
  const std::string colors = (test::project_data_dir() / "colors" / "red.colors").lexically_normal().string();
  const Ending ending = run("track first.png second.png --colors '" + colors + "' -o tracks.csv");
  EXPECT_EQ(ending.code, 2);
  EXPECT_THAT(ending.messages, HasSubstr("error: second.png: found 80 x 60 pixels"));
  EXPECT_EQ(names().count("tracks.csv"), 0u);
}

class Display : public test::ProgramTest {
 protected:
  /// `count` pictures without a ball in the folder "pictures".
  void put_grey_pictures(int count) const {
    std::filesystem::create_directory(dir / "pictures");
    put_grey_picture("grey.png");
    for (int k = 0; k < count; ++k) {
      std::filesystem::create_symlink(dir / "grey.png", dir / "pictures" / (std::to_string(k) + ".png"));
    }
  }
  static std::string track() {
    return "track pictures --display --colors '" +
           (test::project_data_dir() / "colors" / "red.colors").lexically_normal().string() +
           "' -o tracks.csv --json results.json";
  }
  static bool has_virtual_display() {
    return std::system("command -v Xvfb >/dev/null && command -v xdotool >/dev/null") == 0;
  }
  /// To put before a command: a screen for it alone, and what its user does there in the shell's words.
  static std::string on_virtual_display(const std::string& user) {
    return R"(sh -c 'Xvfb -nolisten tcp -displayfd 1 >display 2>/dev/null & server=$!; )"
           R"(until [ -s display ]; do sleep 0.05; done; export DISPLAY=:$(cat display); )"
           R"("$@" & program=$!; )" +
           user + R"(wait $program; code=$?; kill $server; wait $server; rm display; exit $code' sh)";
  }
};

TEST_F(Display, WhereThereIsNoneIsRefusedBeforeAnythingIsWritten) {
  put_grey_pictures(2);
  const std::set<std::string> before = names();
  for (const char* environment :
       {"env -u DISPLAY -u WAYLAND_DISPLAY", "env -u WAYLAND_DISPLAY DISPLAY=:9871"}) {
    const Ending ending = run(track(), environment);
    EXPECT_EQ(ending.code, 2) << environment;
    EXPECT_THAT(ending.messages, HasSubstr("error: --display: found ")) << environment;
    EXPECT_THAT(ending.messages, HasSubstr("DISPLAY")) << environment;
  }
  EXPECT_EQ(names(), before);
}

TEST_F(Display, AKeyEndsAsAnInterruptDoes) {
  if (!has_virtual_display()) GTEST_SKIP() << "no Xvfb or xdotool";
  put_grey_pictures(20000);
  for (const std::string key : {"q", "Escape"}) {
    const Ending ending = run(
        track() + " --force",
        on_virtual_display(
            // A window that was just made may not be viewable yet, and then takes no focus.
            R"(for try in 1 2 3 4 5 6 7 8 9 10; do kill -0 $program || break; )"
            R"(window=$(timeout 12 xdotool search --sync --onlyvisible --name "ballservo track" | tail -n 1); )"
            R"(xdotool windowfocus --sync $window key )" +
            key + R"( && break; sleep 0.2; [ $try -lt 10 ] || kill -KILL $program; done; )"));
    EXPECT_EQ(ending.code, 130) << key << ending.messages;
    EXPECT_THAT(contents("results.json"), HasSubstr("\"interrupted\": true")) << key;
  }
}

TEST_F(Display, ShowsToTheEndWhereNobodyEndsIt) {
  if (!has_virtual_display()) GTEST_SKIP() << "no Xvfb or xdotool";
  put_grey_pictures(3);
  const Ending ending = run(track(), on_virtual_display(""));
  EXPECT_EQ(ending.code, 1);
  EXPECT_THAT(ending.messages, HasSubstr("no ball in 3 pictures"));
}

TEST_F(Display, ShowsPicturesInTheirOwnSizeAndAtTheirOwnPace) {
  if (!has_virtual_display()) GTEST_SKIP() << "no Xvfb or xdotool";
  put_grey_pictures(60);
  const auto begin = std::chrono::steady_clock::now();
  run(track() + " --fps 15",
      on_virtual_display(
          R"(window=$(timeout 12 xdotool search --sync --onlyvisible --name "ballservo track" | tail -n 1); )"
          R"(sleep 0.5; xdotool getwindowgeometry --shell $window >geometry; )"));
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(59 * 1000 / 15));
  const std::string geometry = contents("geometry");
  EXPECT_THAT(geometry, HasSubstr("WIDTH=160\n"));
  EXPECT_THAT(geometry, HasSubstr("HEIGHT=120\n"));
}

class ProgramWithVideos : public test::ProgramTest {
 protected:
  static constexpr int pictures = 20;

  /// A video of noise without colour, which no codec makes small.
  void put_noise_video(const std::string& name) const {
    VideoFile video(dir / name, Overwrite::refuse, 30);
    cv::RNG random(1);
    for (int i = 0; i < pictures; ++i) {
      cv::Mat grey(120, 160, CV_8U), bgr;
      random.fill(grey, cv::RNG::UNIFORM, 0, 256);
      cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
      video.write(bgr);
    }
    video.commit();
  }
  /// Follows red balls in a video.
  Ending track(const std::string& arguments, const std::string& before = "") const {
    const std::filesystem::path colors = test::project_data_dir() / "colors" / "red.colors";
    return run("track " + arguments + " --colors '" + colors.lexically_normal().string() + "'", before);
  }
};

TEST_F(ProgramWithVideos, AVideoThatIsCutOffIsSaidToBe) {
  put_noise_video("whole.mkv");
  std::filesystem::copy_file(dir / "whole.mkv", dir / "cut.mkv");
  std::filesystem::resize_file(dir / "cut.mkv", std::filesystem::file_size(dir / "whole.mkv") / 2);
  EXPECT_THAT(track("cut.mkv").messages, HasSubstr("cut off or damaged"));
  EXPECT_THAT(track("whole.mkv").messages, testing::Not(HasSubstr("cut off")));
}

TEST_F(ProgramWithVideos, AVideoThatFindsNoRoomIsNotLeftHalfWritten) {
  put_noise_video("noise.mkv");
  for (const std::string video : {"tracked.mkv", "tracked.mp4"}) {
    const Ending ending = track("noise.mkv --video " + video, "ulimit -f 8;");
    EXPECT_EQ(ending.code, 2) << ending.messages;
    EXPECT_THAT(ending.messages, HasSubstr(video + ": found a video that could not be written whole"));
    EXPECT_EQ(names(), std::set<std::string>{"noise.mkv"});
  }
  EXPECT_EQ(track("noise.mkv --video tracked.mkv").code, 1);
  EXPECT_EQ(names().count("tracked.mkv"), 1u);
}

}  // namespace
}  // namespace ballservo
