// Teaching by showing, and what a robot does that believes the wrong things.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "app/experiment/run_log.hpp"
#include "app/experiment/runner.hpp"
#include "calibration/base/fault.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

using test::run;
using test::static_ball;

const std::vector<std::string> wrong_beliefs{"believed.diameter_scale=1.05", "believed.focal_scale=1.02"};

class Taught : public testing::Test {
 protected:
  /// Teaches with `sets` and returns them with the target that was taught.
  std::vector<std::string> teach(std::vector<std::string> sets,
                                 PerceptionLevel level = PerceptionLevel::geometric) const {
    const Scenario scenario = static_ball(77, sets);
    TeachOptions options;
    options.perception = level;
    options.colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
    const std::filesystem::path file = folder.path() / "target.yaml";
    std::ofstream(file) << taught_target_yaml(teach_target(scenario, options));
    sets.push_back("target={ball: target, taught: " + file.string() + "}");
    return sets;
  }
  test::TemporaryFolder folder;
};

TEST_F(Taught, EveryLawStopsWhereItWasShownWithAWrongDiameterAndFocalLength) {
  const std::vector<std::string> sets = teach(wrong_beliefs);
  for (const std::string& law : builtin_laws().names()) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      std::vector<std::string> with_law = sets;
      with_law.push_back("law.name=" + law);
      const RunSummary s = run(static_ball(seed, with_law), PerceptionLevel::geometric).summary;
      EXPECT_EQ(s.outcome, Outcome::reached) << law << ", seed " << seed << ": " << s.outcome_text;
      EXPECT_LE(std::abs(s.range_error_m), 0.002) << law;
    }
  }
}

TEST_F(Taught, CoarselyWrongBeliefsHardlyDelayIt) {
  const double right_s = run(static_ball(4, teach({})), PerceptionLevel::geometric).summary.settled_s;
  for (const char* belief :
       {"diameter_scale=0.4", "diameter_scale=3", "focal_scale=0.5", "focal_scale=2", "pitch_error_rad=-0.2",
        "pitch_error_rad=0.2", "forward_error_m=0.2", "up_error_m=0.15", "latency_error_s=0.03"}) {
    const RunSummary s =
        run(static_ball(4, teach({std::string("believed.") + belief})), PerceptionLevel::geometric).summary;
    EXPECT_EQ(s.outcome, Outcome::reached) << belief << ": " << s.outcome_text;
    EXPECT_LT(s.settled_s, right_s + 0.6) << belief;
    EXPECT_EQ(s.ball_contacts, 0) << belief;
  }
}

// It seems to lie 0.4 m below the floor.
TEST_F(Taught, ABallThatIsBelievedThriceAsLargeIsReachedThroughPictures) {
  const Scenario scenario = static_ball(4, teach({"believed.diameter_scale=3"}, PerceptionLevel::image));
  const RunRecord record = run(scenario, PerceptionLevel::image);
  EXPECT_EQ(record.summary.outcome, Outcome::reached) << record.summary.outcome_text;

  const OutputFolder page(folder.path() / "page", Overwrite::allow);
  const auto report = run_report(record, scenario, "image", page);
  const auto outlines =
      report["image"]["outlines_px"].get<std::map<std::string, std::vector<std::array<double, 2>>>>();
  for (int axis = 0; axis < 2; ++axis)
    EXPECT_NEAR(outlines.at("desired")[0][axis], outlines.at("last")[0][axis], 1.0) << "where it should end";
}

TEST_F(Taught, WithoutTeachingTheSameBeliefsMissByCentimetres) {
  const RunSummary s = run(static_ball(0, wrong_beliefs), PerceptionLevel::truth).summary;
  EXPECT_EQ(s.outcome, Outcome::timeout);
  // 7 % nearer than believed, of the way from camera to ball.
  EXPECT_NEAR(s.range_error_m, -0.05, 0.01);
}

TEST_F(Taught, WhatIsTaughtDoesNotDependOnTheBelievedDiameter) {
  TeachOptions options;
  options.perception = PerceptionLevel::truth;
  const Eigen::Vector3d plain = teach_target(static_ball(1), options).center_over_radius;
  const Eigen::Vector3d scaled =
      teach_target(static_ball(1, {"believed.diameter_scale=1.3"}), options).center_over_radius;
  EXPECT_NEAR((plain - scaled).norm(), 0, 1e-9);
  const Scenario scenario = static_ball(1);
  EXPECT_NEAR((plain * 0.06 - scenario.goal().desired_p_CB()).norm(), 0, 1e-9);
}

TEST_F(Taught, AFileIsReadBackAsItWasWritten) {
  TaughtTarget target;
  target.ball = "target";
  target.center_over_radius = {1.0 / 3, -0.1, 13.25};
  target.sigma = {1e-5, 2e-5, 3e-4};
  target.frames = 60;
  target.distance_m = 0.8;
  std::ofstream(folder.path() / "t.yaml") << taught_target_yaml(target);
  const TaughtTarget read = read_taught_target(folder.path() / "t.yaml");
  EXPECT_EQ(read.center_over_radius, target.center_over_radius);
  EXPECT_EQ(read.sigma, target.sigma);
  EXPECT_EQ(read.frames, 60);
  EXPECT_EQ(read.distance_m, 0.8);
  for (const char* bad :
       {"", "ball: x\n",
        "ball: target\ncenter_over_radius: [0, 0, -3]\nsigma: [0, 0, 0]\nframes: 1\ndistance_m: 1\n",
        "ball: target\ncenter_over_radius: [0, 0]\nsigma: [0, 0, 0]\nframes: 1\ndistance_m: 1\n",
        "ball: target\ncenter_over_radius: [0, 0, .nan]\nsigma: [0, 0, 0]\nframes: 1\ndistance_m: 1\n"}) {
    std::ofstream(folder.path() / "bad.yaml", std::ios::trunc) << bad;
    EXPECT_THROW(read_taught_target(folder.path() / "bad.yaml"), InputError) << bad;
  }
}

TEST_F(Taught, ScenariosSayWhatIsWrongWithATaughtTarget) {
  const auto faults = [](const std::vector<std::string>& sets) -> std::string {
    try {
      static_ball(0, sets);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(faults({"target={ball: target, taught: nowhere.yaml}"}), "");
  EXPECT_NE(faults({"target.taught=target.yaml"}), "");
  EXPECT_NE(faults({"believed.focal_scale=0"}), "");
  EXPECT_NE(faults({"believed.latency_error_s=-0.05"}), "");
  EXPECT_EQ(faults({"believed.latency_error_s=-0.033"}), "");
}

TEST_F(Taught, ARobotThatCouldNotStandAtTheGoalRefuses) {
  TeachOptions options;
  options.perception = PerceptionLevel::truth;
  const Scenario blocked =
      static_ball(0, {"balls.0.position.x_m=3.0", "balls.0.position.y_m=0.0", "robot.pose.yaw_rad=0",
                      "obstacles=[{type: box, name: step, position: {x_m: 2.2, y_m: 0.0}, size: {x_m: 0.2, "
                      "y_m: 0.4, z_m: 0.05}}]"});
  EXPECT_THROW(teach_target(blocked, options), Refusal);
  const Scenario hidden =
      static_ball(0, {"balls.0.position.x_m=3.0", "balls.0.position.y_m=0.0", "robot.pose.yaw_rad=0",
                      "obstacles=[{type: box, name: screen, position: {x_m: 2.7, y_m: 0.0}, size: {x_m: 0.1, "
                      "y_m: 0.4, z_m: 0.3}}]"});
  EXPECT_THROW(teach_target(hidden, options), Refusal);
}

TEST(Beliefs, AWrongLatencyIsSurvived) {
  for (const char* error_s : {"-0.03", "0.03"}) {
    const RunSummary s =
        run(static_ball(2, {std::string("believed.latency_error_s=") + error_s}), PerceptionLevel::geometric)
            .summary;
    EXPECT_EQ(s.outcome, Outcome::reached) << error_s << ": " << s.outcome_text;
  }
}

TEST(GainWarning, NamesTheLimitForRateAndDelay) {
  EXPECT_EQ(gain_warning(static_ball(0)), "");
  const std::string slow =
      gain_warning(static_ball(0, {"camera.rate_hz=10", "camera.latency_s=0.35", "law.gain_per_s=4"}));
  // 0.4 s are four periods of 0.1 s: 2 sin(pi / 18) / 0.1 s.
  EXPECT_THAT(slow, testing::HasSubstr("above 3.47"));
}

}  // namespace
}  // namespace ballservo
