// The judge, the yardstick and the log on made-up runs.
#include <gtest/gtest.h>

#include <cmath>

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_log.hpp"
#include "app/scenario/feasibility.hpp"

namespace ballservo {
namespace {

/// Steps at 50 Hz until the judge ends them or `duration_s` has passed.
template <typename Fill>
RunSummary judged(double duration_s, bool moving, Fill fill) {
  OutcomeJudge judge(duration_s, moving);
  std::vector<StepRecord> steps;
  for (long k = 0; !judge.over(); ++k) {
    StepRecord step;
    step.step = k;
    step.time_s = static_cast<double>(k) / 50;
    step.clearance_m = step.ball_clearance_m = 1;
    step.in_view = true;
    std::string touched;
    fill(step, touched);
    judge.look(step, touched);
    steps.push_back(step);
  }
  return judge.summary(steps, false);
}

TEST(OutcomeJudge, ReachedIsHeldForASecondAndSettledIsItsStart) {
  const RunSummary s = judged(20, false, [](StepRecord& step, std::string&) {
    step.range_error_m = step.time_s < 3 ? 0.011 : 0.004;
  });
  EXPECT_EQ(s.outcome, Outcome::reached);
  EXPECT_DOUBLE_EQ(s.settled_s, 3.0);
  EXPECT_NEAR(s.duration_s, 4.5, 1e-9);
  EXPECT_NEAR(s.range_error_m, 0.004, 1e-12);
  EXPECT_NEAR(s.range_rms_m, 0.004, 1e-12);
}

TEST(OutcomeJudge, PassingThroughTheGoalIsNotReaching) {
  const RunSummary s = judged(10, false, [](StepRecord& step, std::string&) {
    step.range_error_m = std::fmod(step.time_s, 1.0) < 0.9 ? 0.0 : 0.02;
    step.control.reason = "it passes by";
  });
  EXPECT_EQ(s.outcome, Outcome::timeout);
  EXPECT_EQ(s.outcome_text, "the robot did not reach the ball within 10 s, at last: it passes by");
  EXPECT_TRUE(std::isnan(s.settled_s));
}

TEST(OutcomeJudge, EachLimitCounts) {
  const auto with = [](double range_m, double bearing_rad, double v_mps) {
    return judged(5, false,
                  [=](StepRecord& step, std::string&) {
                    step.range_error_m = range_m;
                    step.bearing_rad = bearing_rad;
                    step.twist.v_mps = v_mps;
                  })
        .outcome;
  };
  const double degree = 0.017453292519943295;
  EXPECT_EQ(with(-0.0099, -0.49 * degree, -0.0049), Outcome::reached);
  EXPECT_EQ(with(-0.0101, 0, 0), Outcome::timeout);
  EXPECT_EQ(with(0, 0.51 * degree, 0), Outcome::timeout);
  EXPECT_EQ(with(0, 0, -0.0051), Outcome::timeout);
}

TEST(OutcomeJudge, AMovingBallIsFollowedForFourFifthsOfTheLastFiveSeconds) {
  const auto with_share = [](double share) {
    return judged(10, true, [share](StepRecord& step, std::string&) {
      step.range_error_m = std::fmod(step.time_s, 1.0) < share ? 0.04 : 0.06;
      step.twist.v_mps = 0.5;
    });
  };
  EXPECT_EQ(with_share(0.9).outcome, Outcome::reached);
  EXPECT_EQ(with_share(0.7).outcome, Outcome::timeout);
  EXPECT_TRUE(std::isnan(with_share(0.7).settled_s));
}

TEST(OutcomeJudge, CollisionsAndBallsThatRollIntoARestingRobotEndTheRun) {
  const RunSummary collision = judged(20, false, [](StepRecord& step, std::string& touched) {
    step.range_error_m = 1;
    if (step.time_s > 1) touched = "crate";
  });
  EXPECT_EQ(collision.outcome, Outcome::collision);
  EXPECT_EQ(collision.collision_cause, "none_broken");

  const RunSummary hit =
      judged(20, true, [](StepRecord& step, std::string&) { step.ball_clearance_m = 0.5 - step.time_s; });
  EXPECT_EQ(hit.outcome, Outcome::hit_by);
  EXPECT_EQ(hit.collision_cause, "");

  const RunSummary ran_into = judged(3, false, [](StepRecord& step, std::string&) {
    step.range_error_m = 1;
    step.twist.v_mps = 0.3;
    step.ball_clearance_m = std::abs(step.time_s - 1) < 0.1 ? 0 : 1;
  });
  EXPECT_EQ(ran_into.outcome, Outcome::timeout);
  EXPECT_EQ(ran_into.ball_contacts, 1);
}

TEST(OutcomeJudge, LostAndFault) {
  EXPECT_EQ(judged(20, false,
                   [](StepRecord& step, std::string&) {
                     step.range_error_m = 1;
                     if (step.time_s > 2) step.control.state = ControlState::given_up;
                   })
                .outcome,
            Outcome::lost);
  const RunSummary fault = judged(20, false, [](StepRecord& step, std::string&) {
    step.range_error_m = 1;
    if (step.time_s > 2) step.control.state = ControlState::fault;
  });
  EXPECT_EQ(fault.outcome, Outcome::fault);
  EXPECT_NEAR(fault.duration_s, 3.02, 0.021);
}

TEST(TimeOptimal, IsTheTrapezoid) {
  EXPECT_DOUBLE_EQ(rest_to_rest_s(0, 1.2, 0.3), 0);
  EXPECT_DOUBLE_EQ(rest_to_rest_s(1.2, 1.2, 0.3), 4.0);        // a triangle: 2 sqrt(way / a)
  EXPECT_DOUBLE_EQ(rest_to_rest_s(4.8 + 1.2, 1.2, 0.3), 9.0);  // two ramps of 4 s and one second at 1.2 m/s
  EXPECT_DOUBLE_EQ(rest_to_rest_s(-1.2, 1.2, 0.3), rest_to_rest_s(1.2, 1.2, 0.3));
  // Three metres straight ahead: 6.3 s.
  EXPECT_NEAR(time_optimal_s({}, {3.8, 0.0}, 0.8, UnicycleLimits{}), 6.32, 0.01);
  EXPECT_GT(time_optimal_s({}, {0.0, 3.8}, 0.8, UnicycleLimits{}), 6.33);
}

TEST(LogCsv, HasTheContractsColumnsAndRoundTrips) {
  StepRecord step;
  step.time_s = 0.1 + 0.2;
  step.control.reason = "a comma, and a \"quote\"";
  const std::string csv = log_csv({step});
  const std::string contract =
      "step,time_s,x_m,y_m,yaw_rad,v_mps,w_radps,v_command_mps,w_command_radps,state,reason,track_state,"
      "error_1,error_2,range_m,bearing_rad,clearance_m";
  EXPECT_EQ(csv.substr(0, contract.size()), contract);
  EXPECT_EQ(csv.substr(contract.size(), csv.find('\n') - contract.size()),
            ",v_intended_mps,w_intended_radps,shield,in_view,hidden,pan_rad,pan_command_radps");
  EXPECT_NE(csv.find("0.30000000000000004"), std::string::npos);
  EXPECT_NE(csv.find("\"a comma, and a \"\"quote\"\"\""), std::string::npos);
  EXPECT_NE(csv.find(",none,,,"), std::string::npos);  // unknown errors stay empty
}

TEST(SummaryJson, HasTheContractsKeysAndNullForWhatIsNotKnown) {
  const auto json = summary_json({}, {});
  for (const char* key : {"outcome", "settled_s", "time_optimal_s", "range_error_m", "bearing_error_rad",
                          "range_rms_m", "bearing_rms_rad", "min_clearance_m", "out_of_view_s", "lost_events",
                          "collision_cause", "steps", "timing"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["settled_s"].dump(), "null");
  EXPECT_TRUE(json["timing"]["image_to_command_ms"].contains("p99"));
  EXPECT_TRUE(json["timing"]["control_us"].contains("p50"));
}

}  // namespace
}  // namespace ballservo
