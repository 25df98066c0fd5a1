// Runs through rendered frames: minutes of work.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

class StaticBallSeed : public testing::TestWithParam<std::uint64_t> {};

TEST_P(StaticBallSeed, IsReachedThroughRenderedFrames) {
  const RunRecord record = test::run(test::static_ball(GetParam()), PerceptionLevel::image);
  EXPECT_EQ(record.summary.outcome, Outcome::reached) << record.summary.outcome_text;
  EXPECT_LE(std::abs(record.summary.range_error_m), 0.005);
  EXPECT_LE(std::abs(record.summary.bearing_error_rad), 0.2 * 0.017453292519943295);
}

INSTANTIATE_TEST_SUITE_P(Seeds, StaticBallSeed, testing::Range<std::uint64_t>(0, 10));

// Half a minute behind a ball into the darker end of a corridor, where its blue and green are lost in noise.
TEST(MovingBall, IsFollowedThroughRenderedFrames) {
  const Scenario scenario =
      load_scenario(test::project_data_dir() / "scenarios" / "moving_ball.yaml", {}, 83009);
  const RunSummary run = test::run(scenario, PerceptionLevel::image).summary;
  EXPECT_EQ(run.outcome, Outcome::reached) << run.outcome_text;
}

TEST(RenderedFrames, ShowTheBallOfEveryScenarioInTheTaughtLight) {
  int in_sight_at_first = 0;  // scenarios
  for (const auto& entry : std::filesystem::directory_iterator(test::project_data_dir() / "scenarios")) {
    const Scenario scenario = load_scenario(entry.path(), {"duration_s=1"}, 0);
    if (scenario.colors.empty()) continue;  // it teaches them
    int in_sight = 0, seen = 0;
    const RunRecord record = test::run(scenario, PerceptionLevel::image);
    for (const FrameRecord& frame : record.frames) {
      if (frame.visible_fraction < 0.98) continue;
      ++in_sight;
      seen += frame.measurement.state == TrackState::confirmed ? 1 : 0;
    }
    EXPECT_GE(seen, 0.5 * in_sight) << entry.path();
    EXPECT_FALSE(record.assumed_light) << entry.path();
    in_sight_at_first += in_sight > 0 ? 1 : 0;
  }
  EXPECT_GE(in_sight_at_first, 10);
}

}  // namespace
}  // namespace ballservo
