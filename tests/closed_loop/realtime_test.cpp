// Runs on the wall clock: what the guard promises, and that threads neither race nor hang.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <future>

#include "calibration/base/random.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

Scenario scenario_of(std::uint64_t seed) {
  const char* file = seed % 2 == 0 ? "static_ball.yaml" : "obstacles.yaml";
  return load_scenario(test::project_data_dir() / "scenarios" / file, {}, seed);
}

bool rests(const Twist2& command) { return command.v_mps == 0.0 && command.w_radps == 0.0; }

/// The scenario's drive, which notes what it is told.
class NotedDrive final : public UnicycleRobot {
 public:
  struct Command {
    double time_s;
    Twist2 twist;
  };
  explicit NotedDrive(const RobotSettings& robot)
      : UnicycleRobot(robot.pose, robot.limits, robot.actuation_delay_s) {}
  void command(const Twist2& twist) override {
    commands.push_back({time_s(), twist});
    UnicycleRobot::command(twist);
  }
  std::vector<Command> commands;
};

struct NotedRun {
  RunRecord record;
  std::vector<NotedDrive::Command> commands;
};

NotedRun noted_run(const Scenario& scenario, RunOptions options) {
  const auto drive = std::make_shared<NotedDrive>(scenario.robot);
  options.body = drive;
  RunRecord record = run_realtime(scenario, options);
  return {std::move(record), drive->commands};
}

/// A run whose camera gives nothing from that time on, ended when everything must long have happened.
NotedRun run_with_camera_until(double stop_s, std::uint64_t seed) {
  Scenario scenario = scenario_of(seed);
  scenario.camera.faults.push_back({CameraFault::Kind::dropped, stop_s});
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  options.go_on = [stop_s](double time_s) { return time_s < stop_s + 0.45; };
  return noted_run(scenario, options);
}

/// How long the drive went on following a command after the last frame had arrived (s).
double followed_blindly_s(const NotedRun& run) {
  const auto& frames = run.record.frames;
  const double last_frame_s = frames.empty() ? 0.0 : frames.back().arrived_s;
  double rest_s = last_frame_s;
  for (const NotedDrive::Command& command : run.commands) {
    if (command.time_s <= last_frame_s) {
      rest_s = rests(command.twist) ? command.time_s : 1e9;
    } else if (rests(command.twist)) {
      rest_s = std::min(rest_s, command.time_s);
    } else if (rest_s < 1e9 && command.time_s > last_frame_s) {
      rest_s = 1e9;
    }
  }
  return std::max(rest_s - last_frame_s, 0.0);
}

double longest_guard_period_s(const RunRecord& run) {
  const auto& periods = run.timing.realtime->guard_period_ms;
  return 1e-3 * *std::max_element(periods.begin(), periods.end());
}

// 200 ms and one period of control. What the machine itself slept is allowed for: the longest time between
// two looks of the guard.
TEST(Realtime, TheDriveRestsSoonAfterTheCameraStopsAtAnyInstant) {
  RandomEngine engine = random_stream(0, "camera stops");
  constexpr int instants = 50, at_once = 10;
  int drove = 0;
  for (int done = 0; done < instants; done += at_once) {
    std::vector<std::future<NotedRun>> runs;
    for (int k = 0; k < at_once; ++k) {
      const double stop_s = uniform(engine, 0.5, 2.0);
      runs.push_back(std::async(std::launch::async, run_with_camera_until, stop_s, 100u + k));
    }
    for (auto& each : runs) {
      const NotedRun run = each.get();
      EXPECT_LE(followed_blindly_s(run), 0.2 + 0.02 + longest_guard_period_s(run.record));
      drove += std::any_of(run.commands.begin(), run.commands.end(),
                           [](const NotedDrive::Command& c) { return c.twist.v_mps > 0.1; });
    }
  }
  EXPECT_GE(drove, instants / 2) << "robots that rest anyway show nothing";
}

TEST(Realtime, ADeadControllerIsStoppedByTheGuard) {
  const Scenario scenario = scenario_of(100);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  options.go_on = [](double time_s) {
    if (time_s > 1.5) std::this_thread::sleep_for(std::chrono::milliseconds(400));
    return time_s <= 1.5;
  };
  const auto [run, commands] = noted_run(scenario, options);
  const double last_step_s = run.steps.back().time_s;
  const auto rest = std::find_if(
      commands.begin(), commands.end(),
      [last_step_s](const NotedDrive::Command& c) { return c.time_s > last_step_s && rests(c.twist); });
  ASSERT_NE(rest, commands.end());
  EXPECT_LE(rest->time_s - last_step_s, 0.04 + longest_guard_period_s(run) + 0.005);
  EXPECT_GE(run.timing.realtime->guard_rests, 1);
  EXPECT_TRUE(std::all_of(rest, commands.end(), [](const NotedDrive::Command& c) { return rests(c.twist); }));
  EXPECT_EQ(run.summary.outcome, Outcome::interrupted);
}

// Rendering and tracker run on the camera's thread; on that alone, for the sanitizer cannot see how TBB
// joins.
TEST(Realtime, PicturesAreRenderedAndLookedAtBesideControlAndGuard) {
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  const Scenario scenario = scenario_of(100);
  RunOptions options;
  options.perception = PerceptionLevel::image;
  options.colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
  options.go_on = [](double time_s) { return time_s < 1.5; };
  const RunRecord run = run_realtime(scenario, options);
  EXPECT_EQ(run.summary.outcome, Outcome::interrupted);
  EXPECT_FALSE(run.frames.empty());
  EXPECT_FALSE(run.key_frames.empty());
  EXPECT_GT(run.steps.size(), 20u);
}

TEST(Realtime, TheBallIsReachedAsInSimulatedTime) {
  const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "static_ball.yaml",
                                          {"balls.0.position.x_m=1.4", "balls.0.position.y_m=0.1"}, 4);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  const RunRecord run = run_realtime(scenario, options);
  EXPECT_EQ(run.summary.outcome, Outcome::reached) << run.summary.outcome_text;
  EXPECT_LT(std::abs(run.summary.range_error_m), 0.005);
  const RealtimeTiming& wall = *run.timing.realtime;
  EXPECT_FALSE(wall.guard_period_ms.empty());
  EXPECT_NEAR(static_cast<double>(run.steps.size() + wall.steps_skipped),
              run.summary.duration_s * scenario.control_rate_hz, 3);
}

}  // namespace
}  // namespace ballservo
