// Recordings: what a kill leaves is whole, and is found as it was.
#include "app/io/recording.hpp"

#include <signal.h>
#include <spawn.h>

#include <thread>

#include "app/io/image_source.hpp"
#include "calibration/base/fault.hpp"
#include "tests/program/program_run.hpp"

namespace ballservo {
namespace {

using namespace std::chrono_literals;

cv::Mat picture(int grey) { return {30, 40, CV_8UC3, cv::Scalar::all(grey)}; }

class Recording : public test::ProgramTest {};

TEST_F(Recording, ReadsBackThePicturesAndTheirTimes) {
  {
    RecordingWriter writer(dir / "kept", Overwrite::refuse);
    for (int i = 0; i < 5; ++i)
      EXPECT_TRUE(writer.put(picture(10 * i), 0.1 * i + (i == 4 ? 1 : 0), 1e9 + i, ""));
    EXPECT_EQ(writer.kept(), 5);
  }
  const auto sequences = open_sources({(dir / "kept").string()}, 30, 1e6);
  for (int i = 0; i < 5; ++i) {
    const auto frame = sequences.front()->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->time_s, 0.1 * i + (i == 4 ? 1 : 0));
    EXPECT_EQ(cv::norm(frame->bgr, picture(10 * i), cv::NORM_INF), 0);
  }
  EXPECT_FALSE(sequences.front()->next());
}

TEST_F(Recording, TheLastSecondsAreKeptAfterTheFact) {
  RecentPictures recent(1);
  const auto show = [&](int i) {
    recent.put(picture(i), 0.1 * i, 1e9 + i);
    std::this_thread::sleep_for(20ms);  // as a camera does
  };
  for (int i = 0; i < 40; ++i) show(i);
  EXPECT_LE(recent.seconds(), 1);
  EXPECT_GT(recent.seconds(), 0.5);
  write_recording(dir / "kept", Overwrite::refuse, recent.pictures(), {{"settings.json", "{}"}});
  EXPECT_THROW(write_recording(dir / "kept", Overwrite::refuse, recent.pictures(), {}), InputError);
  const auto sequences = open_sources({(dir / "kept").string()}, 30, 1e6);
  ASSERT_EQ(sequences.front()->length(), static_cast<long>(recent.pictures().size()));
  int last = 0;
  for (const CompressedPicture& kept : recent.pictures()) {
    const auto frame = sequences.front()->next();
    EXPECT_NEAR(frame->time_s, kept.time_s - recent.pictures().front().time_s, 1e-12);
    last = frame->bgr.at<cv::Vec3b>(5, 5)[0];
  }
  EXPECT_GE(last, 36) << "the newest but those under way";
  EXPECT_EQ(contents("kept/settings.json"), "{}");
  for (int i = 0; i < 3; ++i) show(i);
  EXPECT_LE(recent.pictures().size(), 2u) << "a time that goes back";
}

TEST_F(Recording, AnUnfinishedLineIsNone) {
  { RecordingWriter(dir / "kept", Overwrite::refuse).put(picture(1), 0, 1e9, ""); }
  put("kept/recording.csv", contents("kept/recording.csv") + "frame_0000001.png,0.0");
  EXPECT_EQ(recorded_pictures(dir / "kept").size(), 1u);
}

TEST_F(Recording, RefusesATableThatLeadsElsewhere) {
  { RecordingWriter(dir / "kept", Overwrite::refuse).put(picture(1), 0, 1e9, ""); }
  const std::string head = "source,time_s,captured_unix_s\n";
  for (const char* line : {"../frame.png,0,0\n", "/etc/passwd,0,0\n", ".hidden.png,0,0\n", "a.png,nan,0\n",
                           "a.png,-1,0\n", "a.png,1,0\nb.png,1,0\n", ",1,0\n", "a.png\n"}) {
    put("kept/recording.csv", head + line);
    EXPECT_THROW(recorded_pictures(dir / "kept"), InputError) << line;
  }
}

TEST_F(Recording, TakesNoFoldersPlaceUnasked) {
  std::filesystem::create_directory(dir / "kept");
  put("kept/mine.txt", "mine");
  EXPECT_THROW(RecordingWriter(dir / "kept", Overwrite::refuse), InputError);
  { RecordingWriter(dir / "kept", Overwrite::allow).put(picture(1), 0, 1e9, ""); }
  { RecordingWriter(dir / "kept", Overwrite::allow).put(picture(2), 0, 1e9, ""); }
  EXPECT_EQ(contents("kept/mine.txt"), "mine");
  EXPECT_EQ(recorded_pictures(dir / "kept").size(), 1u);
}

/// Runs `live` into the folder `kept`, and kills it once it has kept some pictures.
void record_and_kill(const std::filesystem::path& dir, const std::string& colors, std::uintmax_t bytes) {
  std::vector<std::string> words = {
      test::program_path(),    "live",   (dir / "room").string(), "--colors", colors, "--record",
      (dir / "kept").string(), "--quiet"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  ASSERT_EQ(posix_spawn(&child, words[0].c_str(), nullptr, nullptr, arguments.data(), environ), 0);
  std::error_code missing;
  for (int wait = 0; wait < 6000; ++wait) {
    const auto size = std::filesystem::file_size(dir / "kept" / recording_table, missing);
    if (!missing && size > bytes) break;
    std::this_thread::sleep_for(5ms);
  }
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
}

TEST_F(Recording, WhatAKillLeavesGivesTheSameTracks) {
  const std::string data = test::project_data_dir().string(), colors = data + "/colors/red.colors";
  ASSERT_EQ(run("render '" + data + "/scenarios/static_ball.yaml' -o room --frames 60 --quiet").code, 0);
  for (const std::uintmax_t bytes : {200u, 1000u}) {
    std::filesystem::remove_all(dir / "kept");
    record_and_kill(dir, colors, bytes);
    const std::size_t pictures = recorded_pictures(dir / "kept").size();
    ASSERT_GE(pictures, 3u);
    ASSERT_EQ(run("track kept --colors '" + colors + "' -o again.csv --force --quiet").code, 0);
    // What was found in a picture that was not finished is there too, after the rest.
    const std::string again = contents("again.csv"), live = contents("kept/tracks.csv");
    EXPECT_GT(again.size(), 500u);
    EXPECT_EQ(live.substr(0, again.size()), again);
  }
}

}  // namespace
}  // namespace ballservo
