// Streams that are closed, full or broken, and hands that are quick at Ctrl-C.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

#include "tests/hostile/commands.hpp"

const char* ballservo::test::program_path() { return BALLSERVO_PROGRAM; }

namespace ballservo {
namespace {

using Streams = test::Hostile;

TEST_F(Streams, NoMessageEndsACommand) {
  const std::vector<std::string> all = commands();
  ASSERT_GE(all.size(), 13u);
  for (const std::string& command : all) {
    for (const char* to : {"2>/dev/full", "2>&-", "2>&- <&-"})
      EXPECT_EQ(run(command + " --no-such-option " + to + " #").code, 2) << command << to;
    for (const char* to : {">/dev/full", ">&-", ">&- 2>&- <&-"})
      EXPECT_EQ(run(command + " --help " + to + " #").code, 2) << command << to;
    EXPECT_EQ(run(command + " --help 2>&- #").code, 0) << command;
  }
}

TEST_F(Streams, ABrokenPipeEndsNothingBySignal) {
  const auto ending = run("servo --keys", R"(bash -c '{ sleep 0.3; "$0" "$@"; echo $? >code; } | true')");
  EXPECT_EQ(contents("code"), "2\n");
  EXPECT_EQ(ending.messages, "");
  EXPECT_NE(run("servo --keys >/dev/full #").code, 0);
}

TEST_F(Streams, AFullDiskIsNoReaderThatLeft) {
  cv::imwrite((dir / "grey.png").string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(90)));
  const std::string track = "track grey.png --stream - --colors '" +
                            (test::project_data_dir() / "colors/red.colors").string() + "' ";
  EXPECT_EQ(run(track + ">/dev/full 2>said #").code, 2);
  EXPECT_THAT(contents("said"), testing::HasSubstr("stdout: found No space left on device"));
  run(track + "#", R"(bash -c '{ sleep 0.3; "$0" "$@"; echo $? >code; } | true')");
  EXPECT_EQ(contents("code"), "130\n");
}

TEST_F(Streams, AJournalHoldsNoMessageWhereStderrIsClosed) {
  const std::string sweep = "sweep '" + (test::project_data_dir() / "scenarios/static_ball.yaml").string() +
                            "' --trials 3 --set duration_s=1 --threads 1 -o ";
  EXPECT_EQ(run(sweep + "open").code, 0);
  EXPECT_EQ(run(sweep + "closed 2>&- <&- #").code, 0);
  EXPECT_EQ(contents("closed/trials.csv"), contents("open/trials.csv"));
}

/// Whether the process has a handler of SIGINT; before its first instruction signals are the system's.
bool hears(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("SigCgt:", 0) == 0) return std::stoull(line.substr(7), nullptr, 16) >> (SIGINT - 1) & 1;
  return false;
}

/// Its exit code, or minus the signal that ended it; the delay begins with the handler.
int interrupted_after(std::chrono::milliseconds delay) {
  std::string program = BALLSERVO_PROGRAM, keys = "servo", help = "--keys";
  char* arguments[] = {program.data(), keys.data(), help.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  if (posix_spawn(&child, program.c_str(), &actions, nullptr, arguments, environ) != 0) return -1000;
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  bool ended = false;
  while (!ended && !hears(child)) {
    std::this_thread::yield();
    ended = waitpid(child, &status, WNOHANG) == child;
  }
  std::this_thread::sleep_for(delay);
  if (!ended) {
    kill(child, SIGINT);
    waitpid(child, &status, 0);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST_F(Streams, CtrlCIsHeardWhileTheLibrariesLoad) {
  for (int delay_ms = 0; delay_ms < 300; delay_ms += 20) {
    const int code = interrupted_after(std::chrono::milliseconds(delay_ms));
    EXPECT_TRUE(code == 130 || code == 0) << code << " after " << delay_ms << " ms";
  }
}

}  // namespace
}  // namespace ballservo
