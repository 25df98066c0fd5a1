#include "app/scenario/scenario.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "calibration/base/numbers.hpp"
#include "servo/simulation/rendering/truth.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using ::testing::HasSubstr;

std::filesystem::path static_ball() { return test::project_data_dir() / "scenarios" / "static_ball.yaml"; }

/// Every fault of a scenario as one text; empty where there is none.
std::string scenario_faults(const std::vector<std::string>& sets,
                            const std::filesystem::path& file = static_ball()) {
  try {
    load_scenario(file, sets, 0);
  } catch (const InputError& error) {
    std::string text;
    for (const Fault& fault : error.faults()) text += to_text(fault) + "\n";
    return text;
  }
  return {};
}

TEST(Scenario, ReadsWhatTheFileSays) {
  const Scenario scenario = load_scenario(
      static_ball(), {"robot.pose.yaw_rad=0", "balls.0.position.x_m=3", "balls.0.position.y_m=0.4"}, 0);
  EXPECT_EQ(scenario.target_ball().name, "target");
  EXPECT_EQ(scenario.target_ball().position_m, Eigen::Vector3d(3, 0.4, 0.06));
  EXPECT_EQ(scenario.camera.camera.parameters().model, LensModel::brown);
  EXPECT_EQ(scenario.camera.mount.up_m, 0.28);
  EXPECT_EQ(scenario.target_distance_m, 0.8);
  EXPECT_EQ(scenario.law.name, "cone");
  EXPECT_EQ(scenario.robot.actuation_delay_s, 0.05);
  EXPECT_EQ(scenario.camera.sensor.read_noise, 1.5);
}

TEST(Scenario, SeedsVaryTheStartAndTheBallStaysInView) {
  std::vector<double> seen;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Scenario scenario = load_scenario(static_ball(), {}, seed);
    const auto truth =
        ball_truth(scenario.camera.camera, scenario.world, {scenario.X_WC(scenario.robot.pose), 0});
    EXPECT_EQ(truth[scenario.target].visible_fraction, 1.0) << "seed " << seed;
    const double distance = scenario.target_ball().position_m.head<2>().norm();
    EXPECT_GT(distance, 2.5);
    EXPECT_LT(distance, 4.5);
    for (const double other : seen) EXPECT_NE(distance, other);
    seen.push_back(distance);
    EXPECT_EQ(load_scenario(static_ball(), {}, seed).resolved_json, scenario.resolved_json);
  }
}

TEST(Scenario, WhatIsSetIsNotVaried) {
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    EXPECT_EQ(load_scenario(static_ball(), {"robot.pose.yaw_rad=0.01"}, seed).robot.pose.yaw_rad, 0.01);
    for (const char* ball : {"balls.0", "balls[0]"})
      EXPECT_EQ(load_scenario(static_ball(), {std::string(ball) + ".position.x_m=3.3"}, seed)
                    .target_ball()
                    .position_m.x(),
                3.3);
  }
}

TEST(Scenario, SaysAllFaultsAtOnceWithTheirLines) {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "bad.yaml";
  std::ofstream(file) << "duration_s: -1\n"
                         "camera:\n"
                         "  file: missing.yaml\n"
                         "  mount: {forward_m: 0.1, up_m: 0.28, pitch_down_rad: 12}\n"
                         "  rate_hz: 0\n"
                         "  latency_s: -0.1\n"
                         "robot: {pose: {x_m: .nan}, speed: 3}\n"
                         "balls:\n"
                         "  - {name: target, class: red, diameter_m: 0.12 m, position: {x_m: 3, y_m: 0}}\n"
                         "target: {ball: target, distance_m: 0.8}\n"
                         "obstacles:\n"
                         "  - {type: box, position: {x_m: 1}, size: {x_m: 1, y_m: 0, z_m: 1}, yaw_deg: 30}\n";
  const std::string faults = scenario_faults({}, file);
  for (const char* expected :
       {":1: duration_s", ":3: camera.file", ":4: camera.mount.pitch_down_rad", ":5: camera.rate_hz",
        ":6: camera.latency_s", ":7: robot.pose.x_m", ":7: robot.speed", ":9: balls[0].diameter_m",
        ":12: obstacles[0].position.y_m", ":12: obstacles[0].size.y_m", ":12: obstacles[0].yaw_deg"}) {
    EXPECT_THAT(faults, HasSubstr(expected));
  }
}

TEST(Scenario, RefusesWhatCannotBe) {
  EXPECT_THAT(scenario_faults({"camera.file=\"\""}), HasSubstr("camera.file: found an empty name"));
  EXPECT_THAT(scenario_faults({"balls.0.position.x_m=0.1", "balls.0.position.y_m=0.1"}),
              HasSubstr("inside or touching the robot"));
  EXPECT_THAT(scenario_faults({"balls.0.position.x_m=4.9", "balls.0.position.y_m=2.2"}),
              HasSubstr("in obstacle crate"));
  EXPECT_THAT(scenario_faults({"balls.0.position.x_m=6.48"}), HasSubstr("outside the room, or in a wall"));
  EXPECT_THAT(scenario_faults({"balls.0.position.z_m=0.03"}), HasSubstr("floor"));
  EXPECT_THAT(scenario_faults({"obstacles.0.position.x_m=0", "obstacles.0.position.y_m=0"}),
              HasSubstr("on the robot"));
  EXPECT_THAT(scenario_faults({"robot.pose.x_m=-1.4"}),
              testing::ContainsRegex("[(]robot.pose.x_m=-1.4 set, robot.pose.yaw_rad=[-.0-9]+ drawn[)]"));
  EXPECT_THAT(scenario_faults({"robot.pose.x_m=9", "robot.pose.x_m=-1.4"}),
              HasSubstr("(robot.pose.x_m=-1.4 set, robot.pose.yaw_rad="));
  EXPECT_THAT(
      scenario_faults({"vary={'balls[0].diameter_m': {choice: [1]}, balls.0.diameter_m: {choice: [2]}}"}),
      HasSubstr("each key once"));
  EXPECT_THAT(scenario_faults({"vary={camera.rate_hz: {choice: [-3]}}"}),
              HasSubstr("camera.rate_hz: found -3 (drawn); allowed: "));
  EXPECT_THAT(scenario_faults({"target={ball: target, taught: nope.yaml}"}),
              HasSubstr("--set: target.taught: nope.yaml: found No such file"));
  EXPECT_THAT(scenario_faults({"camera.rate_hz=-3"}), HasSubstr("camera.rate_hz: found -3; allowed: "));
  EXPECT_THAT(scenario_faults({"target.ball=other"}), HasSubstr("balls: target"));
  EXPECT_THAT(scenario_faults({"vary={nonsense.key: {uniform: [0, 1]}}"}), HasSubstr("nonsense"));
  EXPECT_THAT(scenario_faults({"vary={robot.pose.x_m: {uniform: [1, 0]}}"}), HasSubstr("falling order"));
  EXPECT_THAT(scenario_faults({"balls.0.motion={type: linear, velocity: {x_mps: 1, y_mps: 0}}"}),
              HasSubstr("outside the room"));
  EXPECT_THAT(
      scenario_faults(
          {"balls.0.motion={type: waypoints, points: [{time_s: 2, x_m: 3, y_m: 0}, {time_s: 2, x_m: 3, "
           "y_m: 1}]}"}),
      HasSubstr("a time after the point before"));
  EXPECT_THAT(scenario_faults({"balls.0.motion={type: waypoints, points: [{time_s: 2, x_m: 9, y_m: 0}]}"}),
              HasSubstr("outside the room"));
  EXPECT_THAT(scenario_faults({"lights=[{type: ambient, changes: [{time_s: 2}, {time_s: 1}]}]"}),
              HasSubstr("a time not before"));
  EXPECT_THAT(scenario_faults({"lights=[{type: ambient, changes: [{time_s: 2, temperature_k: 900}]}]"}),
              HasSubstr("from 1667 to 25000 (K)"));
  for (const char* set : {"no_equals_sign", "law.gain_per_s=", "law.gain_per_s= "})
    EXPECT_THAT(scenario_faults({set}), HasSubstr("key.path=value")) << set;
  EXPECT_THAT(scenario_faults({"balls.0.class=Red"}), HasSubstr("beginning with a letter"));
  EXPECT_EQ(scenario_faults({}), "");
  const std::filesystem::path camera = test::project_data_dir() / "cameras/narrow.yaml";
  EXPECT_THAT(scenario_faults({}, camera),
              testing::MatchesRegex(".*narrow.yaml: found no scenario;[^\n]*\n"));
}

TEST(Scenario, ReadsSonarsOdometryAndTheirFaults) {
  const Scenario scenario = load_scenario(
      static_ball(),
      {"robot.sonar={noise_sigma_m: 0.01, dropout_rate: 0.1}",
       "robot.odometry={distance_share: 0.01, turn_share: 0.02, turn_per_m_radpm: 0.01, excess: 2}",
       "robot.faults=[{type: dead, sonar: 3}, {type: late, array: rear, by_s: 0.5, from_s: 2}]"},
      0);
  ASSERT_TRUE(scenario.robot.sonar);
  EXPECT_EQ(scenario.robot.sonar->noise_sigma_m, 0.01);
  EXPECT_EQ(scenario.robot.sonar->beam.max_range_m, 5.0);
  EXPECT_EQ(scenario.robot.odometry.bound.turn_share, 0.02);
  EXPECT_EQ(scenario.robot.odometry.excess, 2);
  ASSERT_EQ(scenario.robot.sonar_faults.size(), 9u);
  EXPECT_EQ(scenario.robot.sonar_faults[8].transducer, 15u);
  EXPECT_EQ(scenario.robot.sonar_faults[8].amount, 0.5);

  EXPECT_THAT(scenario_faults({"robot.faults=[{type: dead, sonar: 3}]"}), HasSubstr("robot.sonar beside it"));
  EXPECT_THAT(
      scenario_faults({"robot.sonar={}", "robot.faults=[{type: asleep, sonar: 16}, {type: long, sonar: 2}]"}),
      ::testing::AllOf(HasSubstr("one of dead"), HasSubstr("faults[0].sonar"), HasSubstr("faults[1].by_m")));
  EXPECT_THAT(scenario_faults({"robot.sonar={rate_hz: 25}"}), HasSubstr("robot.sonar.rate_hz"));
  EXPECT_THAT(scenario_faults({"robot.odometry={distance_share: .nan}"}), HasSubstr("distance_share"));
}

TEST(Scenario, ReadsTheFaultsOfTheCamera) {
  const Scenario scenario = load_scenario(
      static_ball(),
      {"camera.faults=[{type: dropped, rate: 0.8, from_s: 2}, {type: exposure, level: 0.1, until_s: 4}]"}, 0);
  ASSERT_EQ(scenario.camera.faults.size(), 2u);
  EXPECT_EQ(scenario.camera.faults[0].kind, CameraFault::Kind::dropped);
  EXPECT_EQ(scenario.camera.faults[0].from_s, 2);
  EXPECT_NEAR(scenario.camera.faults[0].burst_frames, 4, 1e-12);  // no shorter ones make up the rate
  EXPECT_EQ(scenario.camera.faults[1].level, 0.1);
  EXPECT_EQ(scenario.camera.faults[1].until_s, 4);

  EXPECT_THAT(scenario_faults(
                  {"camera.faults=[{type: dropped, rate: 1.2}, {type: dropped, rate: 0.9, burst_frames: 3}, "
                   "{type: exposure}, {type: asleep}, {type: dropped, from_s: 3, until_s: 2}, "
                   "{type: exposure, level: 1, rate: 0.5}]"}),
              ::testing::AllOf(HasSubstr("faults[0].rate"), HasSubstr("faults[1].burst_frames"),
                               HasSubstr("faults[2].level"), HasSubstr("one of dropped, exposure"),
                               HasSubstr("faults[4].until_s"), HasSubstr("faults[5].rate")));
}

TEST(Scenario, ATargetOutsideThePictureIsRefusedWithTheDistancesThatWouldDo) {
  const std::string faults = scenario_faults({"target.distance_m=0.4"});
  EXPECT_THAT(faults, HasSubstr("target.distance_m"));
  // What it names must do, and less must not.
  const std::size_t at = faults.find("allowed: ") + 9;
  const double nearest = parse_number(faults.substr(at, 4)).value();
  EXPECT_GT(nearest, 0.4);
  EXPECT_LT(nearest, 0.8);
  EXPECT_EQ(scenario_faults({"target.distance_m=" + faults.substr(at, 4)}), "");
  EXPECT_NE(scenario_faults({"target.distance_m=" + std::to_string(nearest - 0.02)}), "");
}

TEST(Scenario, EveryScenarioOfTheProjectIsValid) {
  for (const auto& entry : std::filesystem::directory_iterator(test::project_data_dir() / "scenarios")) {
    EXPECT_EQ(scenario_faults({}, entry.path()), "") << entry.path();
  }
}

}  // namespace
}  // namespace ballservo
