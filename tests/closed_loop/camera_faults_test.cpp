// Runs whose camera fails for a while: the robot stands within the guard's time, and goes on afterwards.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

/// The command at that time.
Twist2 command_at(const RunRecord& run, double time_s) {
  for (const StepRecord& step : run.steps) {
    if (step.time_s >= time_s - 1e-9) return step.control.command;
  }
  return run.steps.back().control.command;
}

bool rests(const Twist2& command) { return command.v_mps == 0.0 && command.w_radps == 0.0; }

TEST(CameraFaultsInTheLoop, WithoutFramesTheRobotStandsInTimeAndThenGoesOn) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    // The faults' times are such that the robot is on its way.
    const double from_s = 1.0 + 0.13 * static_cast<double>(seed);
    const Scenario scenario =
        test::static_ball(seed, {"camera.faults=[{type: dropped, from_s: " + std::to_string(from_s) +
                                 ", until_s: " + std::to_string(from_s + 1.5) + "}]"});
    const RunRecord run = test::run(scenario, PerceptionLevel::geometric);
    double last_frame_s = 0;
    for (const FrameRecord& frame : run.frames) {
      EXPECT_FALSE(frame.time_s >= from_s && frame.time_s < from_s + 1.5);
      if (frame.time_s < from_s) last_frame_s = frame.time_s + scenario.camera.latency_s;
    }
    EXPECT_GT(command_at(run, from_s).v_mps, 0.1) << "a robot that rests anyway shows nothing";
    const double stands_s = last_frame_s + 0.2 + 1.0 / scenario.control_rate_hz;
    for (double t = stands_s; t < from_s + 1.5; t += 0.02) EXPECT_TRUE(rests(command_at(run, t))) << t;
    EXPECT_EQ(run.summary.outcome, Outcome::reached) << run.summary.outcome_text;
  }
}

TEST(CameraFaultsInTheLoop, BurstsOfLostFramesCostTimeOnly) {
  const Scenario scenario =
      test::static_ball(3, {"camera.faults=[{type: dropped, rate: 0.4, burst_frames: 6}]"});
  const RunRecord run = test::run(scenario, PerceptionLevel::geometric);
  const double expected = run.steps.back().time_s * scenario.camera.rate_hz;
  EXPECT_LT(static_cast<double>(run.frames.size()), 0.8 * expected);
  EXPECT_EQ(run.summary.outcome, Outcome::reached) << run.summary.outcome_text;
}

TEST(CameraFaultsInTheLoop, InPicturesTooDarkTheBallIsNotSeenAndTheRobotStops) {
  for (const PerceptionLevel level : {PerceptionLevel::geometric, PerceptionLevel::image}) {
    const Scenario scenario = test::static_ball(
        5, {"duration_s=3.2", "camera.faults=[{type: exposure, level: 0.02, from_s: 1.5, until_s: 9}]"});
    const RunRecord run = test::run(scenario, level);
    EXPECT_GT(command_at(run, 1.5).v_mps, 0.1);
    int claimed = 0;
    for (const FrameRecord& frame : run.frames) {
      if (frame.time_s >= 1.5) claimed += frame.measurement.state == TrackState::confirmed;
    }
    EXPECT_EQ(claimed, 0);
    // coast_s of the prediction and the latency; searching turns it on the spot later.
    for (double t = 2.2; t < 3.0; t += 0.02) EXPECT_EQ(command_at(run, t).v_mps, 0.0) << t;
  }
}

}  // namespace
}  // namespace ballservo
