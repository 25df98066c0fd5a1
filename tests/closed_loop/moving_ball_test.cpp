// Balls that move and hide, at level geometric.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/statistics.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

constexpr std::uint64_t first_seed = 500, seeds = 9;

std::vector<RunSummary> runs_of(const std::string& name, const std::vector<std::string>& sets = {}) {
  std::vector<RunSummary> runs;
  for (std::uint64_t seed = first_seed; seed < first_seed + seeds; ++seed) {
    const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / name, sets, seed);
    runs.push_back(test::run(scenario, PerceptionLevel::geometric).summary);
  }
  return runs;
}

double median_of(const std::vector<RunSummary>& runs, double RunSummary::*value) {
  std::vector<double> values;
  for (const RunSummary& run : runs) values.push_back(run.*value);
  return median(values);
}

TEST(MovingBall, IsFollowedThroughItsBounces) {
  const std::vector<RunSummary> runs = runs_of("moving_ball.yaml");
  for (const RunSummary& run : runs) {
    EXPECT_EQ(run.outcome, Outcome::reached) << run.outcome_text;
    EXPECT_EQ(run.ball_contacts, 0);
  }
  EXPECT_LE(median_of(runs, &RunSummary::range_rms_m), 0.015);
  EXPECT_LE(median_of(runs, &RunSummary::bearing_rms_rad), 0.3 * M_PI / 180);
}

TEST(FleeingBall, IsCaughtUpWithOnTheOpenFloor) {
  for (const RunSummary& run : runs_of("flee.yaml")) {
    EXPECT_EQ(run.outcome, Outcome::reached) << run.outcome_text;
    EXPECT_LE(run.settled_s, 20.0);
  }
}

TEST(BallThatComesTowards, IsNotTouched) {
  for (const RunSummary& run : runs_of("towards.yaml")) {
    EXPECT_EQ(run.outcome, Outcome::reached) << run.outcome_text;
    EXPECT_EQ(run.ball_contacts, 0);
  }
}

TEST(OccludedBall, IsLostWhileHiddenAndFoundAgain) {
  int lost = 0;
  for (const RunSummary& run : runs_of("occlusion.yaml")) {
    EXPECT_EQ(run.outcome, Outcome::reached) << run.outcome_text;
    EXPECT_EQ(run.collision_cause, "");
    lost += run.lost_events > 0 ? 1 : 0;
  }
  EXPECT_GE(lost, 5);  // the screen does hide it
}

}  // namespace
}  // namespace ballservo
