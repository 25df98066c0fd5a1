// Runs on the wall clock: what the guard promises, and that threads neither race nor hang.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <numeric>
#include <system_error>

#include "app/experiment/realtime_runner.hpp"
#include "calibration/base/random.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

Scenario scenario_of(std::uint64_t seed) {
  const char* file = seed % 2 == 0 ? "static_ball.yaml" : "obstacles.yaml";
  return load_scenario(test::project_data_dir() / "scenarios" / file, {}, seed);
}

bool rests(const Twist2& command) { return command.v_mps == 0.0 && command.w_radps == 0.0; }

/// A run whose camera gives nothing from that time on, ended when everything must long have happened.
RealtimeRun run_with_camera_until(double stop_s, std::uint64_t seed) {
  const Scenario scenario = scenario_of(seed);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  options.seed = seed;
  options.go_on = [stop_s](double time_s) { return time_s < stop_s + 0.45; };
  RealtimeOptions realtime;
  realtime.camera_lives = [stop_s](double time_s) { return time_s < stop_s; };
  return run_realtime(scenario, options, realtime);
}

/// How long the drive went on following a command after the last frame had arrived (s).
double followed_blindly_s(const RealtimeRun& run) {
  const double last_frame_s = run.arrivals_s.empty() ? 0.0 : run.arrivals_s.back();
  double rest_s = last_frame_s;
  for (const DriveCommand& command : run.commands) {
    if (command.time_s <= last_frame_s) {
      rest_s = rests(command.command) ? command.time_s : 1e9;
    } else if (rests(command.command)) {
      rest_s = std::min(rest_s, command.time_s);
    } else if (rest_s < 1e9 && command.time_s > last_frame_s) {
      rest_s = 1e9;
    }
  }
  return std::max(rest_s - last_frame_s, 0.0);
}

// 200 ms and one period of control. What the machine itself slept is allowed for: the longest time between
// two looks of the guard.
TEST(Realtime, TheDriveRestsSoonAfterTheCameraStopsAtAnyInstant) {
  RandomEngine engine = random_stream(0, "camera stops");
  constexpr int instants = 50, at_once = 10;
  int drove = 0;
  for (int done = 0; done < instants; done += at_once) {
    std::vector<std::future<RealtimeRun>> runs;
    for (int k = 0; k < at_once; ++k) {
      const double stop_s = uniform(engine, 0.5, 2.0);
      runs.push_back(std::async(std::launch::async, run_with_camera_until, stop_s, 100u + k));
    }
    for (auto& each : runs) {
      const RealtimeRun run = each.get();
      const auto& periods = run.record.timing.realtime->guard_period_ms;
      const double slept_s = 1e-3 * *std::max_element(periods.begin(), periods.end());
      EXPECT_LE(followed_blindly_s(run), 0.2 + 0.02 + slept_s);
      drove += std::any_of(run.commands.begin(), run.commands.end(),
                           [](const DriveCommand& c) { return c.command.v_mps > 0.1; });
    }
  }
  EXPECT_GE(drove, instants / 2) << "robots that rest anyway show nothing";
}

TEST(Realtime, NoCommandPassesTheGuardWhereSensorsAreSilent) {
  const Scenario scenario = scenario_of(100);
  RunRobot robot(scenario, 0);
  const RunClock clock;
  GuardOptions options;
  options.sonars = false;
  GuardedDrive drive(robot, clock, options);
  SensorStamps stamps;
  drive.command({0.3, 0.1}, stamps);
  EXPECT_TRUE(rests(drive.commands().back().command));
  EXPECT_TRUE(drive.commands().back().by_guard);
  EXPECT_TRUE(drive.rested_since_asked());
  stamps.frame_s = stamps.step_s = clock.now_s();
  drive.command({0.3, 0.1}, stamps);
  EXPECT_EQ(drive.commands().back().command.v_mps, 0.3);
  EXPECT_FALSE(drive.rested_since_asked());
}

TEST(Realtime, ADeadControllerIsStoppedByTheGuard) {
  const Scenario scenario = scenario_of(100);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  options.seed = 100;
  options.go_on = [](double time_s) {
    if (time_s > 1.5) std::this_thread::sleep_for(std::chrono::milliseconds(400));
    return time_s <= 1.5;
  };
  const RealtimeRun run = run_realtime(scenario, options, {});
  const DriveCommand& last = run.commands.back();
  EXPECT_TRUE(last.by_guard);
  EXPECT_TRUE(rests(last.command));
  const auto& periods = run.record.timing.realtime->guard_period_ms;
  const double slept_s = 1e-3 * *std::max_element(periods.begin(), periods.end());
  EXPECT_LE(last.time_s - run.record.steps.back().time_s, 0.04 + slept_s + 0.005);
  EXPECT_EQ(run.record.summary.outcome, Outcome::interrupted);
}

TEST(Realtime, AFaultOfTheCameraEndsTheRunAndIsHandedOn) {
  const Scenario scenario = scenario_of(100);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  RealtimeOptions realtime;
  realtime.camera_lives = [](double time_s) -> bool {
    if (time_s > 0.2) throw std::runtime_error("unplugged");
    return true;
  };
  EXPECT_THROW(run_realtime(scenario, options, realtime), std::runtime_error);
}

TEST(Realtime, AThreadThatCannotBeStartedEndsTheOthersAndIsSaidInWords) {
  const Scenario scenario = scenario_of(100);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  for (const int failing : {1, 2, 3}) {
    int asked = 0;
    std::atomic<int> running{0};
    RealtimeOptions realtime;
    realtime.start_thread = [&](std::function<void()> work) {
      if (++asked == failing)
        throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
      ++running;
      return std::thread([&running, work = std::move(work)] {
        work();
        --running;
      });
    };
    try {
      run_realtime(scenario, options, realtime);
      FAIL() << "ran without thread " << failing;
    } catch (const Refusal& refusal) {
      EXPECT_THAT(refusal.what(), testing::HasSubstr("could be started"));
    }
    EXPECT_EQ(asked, failing);
    EXPECT_EQ(running, 0) << "threads that outlive the run";
  }
}

// Rendering and tracker run on the camera's thread; on that alone, for the sanitizer cannot see how TBB
// joins.
TEST(Realtime, PicturesAreRenderedAndLookedAtBesideControlAndGuard) {
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  const Scenario scenario = scenario_of(100);
  RunOptions options;
  options.perception = PerceptionLevel::image;
  options.seed = 100;
  options.colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
  options.go_on = [](double time_s) { return time_s < 1.5; };
  const RealtimeRun run = run_realtime(scenario, options, {});
  EXPECT_EQ(run.record.summary.outcome, Outcome::interrupted);
  EXPECT_FALSE(run.record.frames.empty());
  EXPECT_FALSE(run.record.key_frames.empty());
  EXPECT_GT(run.record.steps.size(), 20u);
}

TEST(Realtime, TheBallIsReachedAsInSimulatedTime) {
  const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "static_ball.yaml",
                                          {"balls.0.position.x_m=1.4", "balls.0.position.y_m=0.1"}, 4);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  options.seed = 4;
  const RealtimeRun run = run_realtime(scenario, options, {});
  EXPECT_EQ(run.record.summary.outcome, Outcome::reached) << run.record.summary.outcome_text;
  EXPECT_LT(std::abs(run.record.summary.range_error_m), 0.005);
  const RealtimeTiming& wall = *run.record.timing.realtime;
  EXPECT_FALSE(wall.guard_period_ms.empty());
  EXPECT_NEAR(static_cast<double>(run.record.steps.size() + wall.steps_skipped),
              run.record.summary.duration_s * scenario.control_rate_hz, 3);
}

}  // namespace
}  // namespace ballservo
