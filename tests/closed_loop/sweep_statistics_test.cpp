#include "app/sweep/sweep_statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/fault.hpp"

namespace ballservo {
namespace {

Trial trial(std::uint64_t seed, Outcome outcome, const std::string& cause = "") {
  Trial t;
  t.scenario_hash = "0123456789abcdef";
  t.seed = seed;
  t.summary.outcome = outcome;
  t.summary.collision_cause = cause;
  t.summary.settled_s = outcome == Outcome::reached ? 6.5 + 0.1 * static_cast<double>(seed) : std::nan("");
  t.summary.time_optimal_s = 6;
  t.last_state = "hold";
  t.last_reason = "a reason, with \"quotes\" and, commas";
  t.why = "so it ended\nin two lines";
  t.drawn = {{"balls.0.position.x_m", 1.0 / 3}, {"robot.pose.yaw_rad", -1e-17}};
  return t;
}

TEST(Trials, AreReadBackAsTheyWereWritten) {
  Trial infeasible = trial(3, Outcome::timeout);
  infeasible.feasible = false;
  infeasible.drawn = {{"balls.0.position.x_m", std::nan("")}, {"robot.pose.yaw_rad", std::nan("")}};
  std::string csv = trials_csv_header({"balls.0.position.x_m", "robot.pose.yaw_rad"});
  for (const Trial& t :
       {trial(1, Outcome::reached), trial(2, Outcome::collision, "none_broken"), infeasible}) {
    csv += trial_row(t);
  }
  const std::vector<Trial> read = parse_trials(csv, "trials.csv");
  ASSERT_EQ(read.size(), 3u);
  std::string again = trials_csv_header({"balls.0.position.x_m", "robot.pose.yaw_rad"});
  for (const Trial& t : read) again += trial_row(t);
  EXPECT_EQ(again, csv);
  EXPECT_EQ(read[0].drawn, trial(1, Outcome::reached).drawn);
  EXPECT_EQ(read[0].why, "so it ended\nin two lines");
}

TEST(Trials, NameTheStateOfTheirEndOnce) {
  Trial t = trial(1, Outcome::timeout);
  EXPECT_EQ(t.cause(), "hold: a reason, with \"quotes\" and, commas");
  t.last_state = "blocked";
  t.last_reason = "blocked: backing up";
  EXPECT_EQ(t.cause(), "blocked: backing up");
}

TEST(Trials, ThatAreNoneAreRefused) {
  const std::string header = trials_csv_header({});
  for (const std::string& bad :
       {std::string(), std::string("seed\n"), header + "a,b\n", header + "h,-1,reached,,,,,,,,,,,0,0,0,,,\n",
        header + "h,1,won,,,,,,,,,,,0,0,0,,,\n", header + "h,1,reached,,nan,,,,,,,,,0,0,0,,,\n"}) {
    EXPECT_THROW(parse_trials(bad, "trials.csv"), InputError) << bad;
  }
  for (const char* bad : {"", "{}", "[]", "{\"seed\":1}", "{\"seed\":\"x\"}", "[[[[[[[[[[[[[[[[[[["}) {
    EXPECT_THROW(seed_of_trace(bad, "traces.jsonl"), InputError) << bad;
  }
}

TEST(SweepStatistics, CountEachTrialOnce) {
  Sweep sweep;
  sweep.description = {{"places", {{"scenario_file", "it's a.yaml"}}},
                       {"scenario", {}},
                       {"perception", "truth"},
                       {"sets", {"law.name=visp", "a=[1, 2]"}},
                       {"trials", 6}};
  for (std::uint64_t seed = 0; seed < 3; ++seed) sweep.trials.push_back(trial(seed, Outcome::reached));
  sweep.trials.push_back(trial(3, Outcome::collision, "none_broken"));
  sweep.trials.push_back(trial(4, Outcome::collision, "low_thing"));
  sweep.trials.push_back(trial(5, Outcome::timeout));
  sweep.trials.back().feasible = false;
  const auto json = sweep_summary_json(sweep, {}, false, nullptr);
  EXPECT_EQ(json["trials"], 6);
  EXPECT_EQ(json["infeasible"], 1);
  EXPECT_EQ(json["reached"], 3);
  EXPECT_EQ(json["collisions"], 2);
  EXPECT_EQ(json["collisions_inside_assumptions"], 1);
  EXPECT_DOUBLE_EQ(json["success_rate"], 0.6);
  EXPECT_DOUBLE_EQ(json["settled_s"]["p50"], 6.6);
  EXPECT_TRUE(json["range_rms_m"]["p50"].is_null());
  EXPECT_EQ(json["failures"].size(), 3u);
  EXPECT_EQ(json["failures"][2]["outcome"], "infeasible");
  EXPECT_EQ(
      trial_command(sweep.description, 7),
      "ballservo servo 'it'\\''s a.yaml' -o seed_7 --seed 7 --perception truth --set law.name=visp --set "
      "'a=[1, 2]' --video");
  EXPECT_EQ(sweep_summary_json(sweep, {2, 3}, true, nullptr)["shard"], "2/3");
}

}  // namespace
}  // namespace ballservo
