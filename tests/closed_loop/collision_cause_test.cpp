// Each assumption of servo/SAFETY.md broken on purpose: the collision that follows is laid to it, and not to
// what else the scenario allows.
#include "app/experiment/collision_cause.hpp"

#include <gtest/gtest.h>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

/// The ball 4 m ahead and nothing else, but for what is set.
Scenario plain(const std::string& obstacles, std::vector<std::string> sets = {}) {
  sets.push_back("obstacles=" + obstacles);
  sets.push_back("balls.0.position.x_m=4");
  sets.push_back("balls.0.position.y_m=0");
  sets.push_back("robot.pose.yaw_rad=0");
  sets.push_back("avoidance.floor=false");  // the camera would see much of what breaks the other assumptions
  sets.push_back("duration_s=40");
  return load_scenario(test::project_data_dir() / "scenarios" / "obstacles.yaml", sets, 0);
}

RunSummary run_plain(const Scenario& scenario) {
  return test::run(scenario, PerceptionLevel::geometric).summary;
}

/// A post that the law alone drives into, the ball beside it in sight.
constexpr const char* post =
    "[{type: cylinder, name: post, position: {x_m: 2, y_m: 0.2}, radius_m: 0.08, height_m: 0.6}]";
constexpr const char* wall_across =
    "[{type: box, name: block, position: {x_m: 2, y_m: 0}, size: {x_m: 0.2, y_m: 4, z_m: 1}}]";
constexpr const char* dropouts = "robot.sonar.dropout_rate=0.02";

TEST(CollisionCause, NothingIsTouchedWhereAllHold) {
  const RunSummary s = run_plain(plain(wall_across));
  EXPECT_EQ(s.collision_cause, "") << s.outcome_text;
}

TEST(CollisionCause, A1WithoutTheShield) {
  EXPECT_EQ(run_plain(plain(post, {"avoidance.type=none", dropouts})).collision_cause, "A1_shield");
}

TEST(CollisionCause, A2WhatMovesIntoTheWayOtherwiseThanReckonedWith) {
  const auto outcome = [](const std::string& moving) {
    return run_plain(plain(
        "[]",
        {"balls=[{name: target, class: red, diameter_m: 0.12, position: {x_m: 4, y_m: 0, z_m: 0.06}}, {name: "
         "cart, class: blue, diameter_m: 0.5, position: {x_m: 1.3, y_m: 2.5, z_m: 0.25}, sonar: true, "
         "motion: "
         "{type: linear, velocity: {x_mps: 0, y_mps: -0.9}, duration_s: 5}}]",
         "avoidance.moving=" + moving, dropouts}));
  };
  EXPECT_EQ(outcome("{speed_mps: 0}").collision_cause, "A2_static");
  EXPECT_EQ(outcome("{speed_mps: 0.05}").collision_cause, "A2_static");
  EXPECT_NE(outcome("{speed_mps: 0.9}").outcome, Outcome::collision);
}
TEST(CollisionCause, A3WhatCrossesNoBeam) {
  const RunSummary s = run_plain(
      plain("[{type: box, name: step, position: {x_m: 1.6, y_m: 0}, size: {x_m: 0.2, y_m: 3, z_m: 0.05}}]"));
  EXPECT_EQ(s.collision_cause, "A3_echo") << s.outcome_text;
}

TEST(CollisionCause, A3WhatThrowsTheSoundAway) {
  const RunSummary s =
      run_plain(plain("[{type: box, name: mirror, position: {x_m: 2.2, y_m: 0}, yaw_rad: 0.785, size: {x_m: "
                      "1, y_m: 1, z_m: 1}}]",
                      {"robot.sonar.specular_limit_rad=0.1"}));
  EXPECT_EQ(s.collision_cause, "A3_echo") << s.outcome_text;
}

TEST(CollisionCause, A4SonarsThatReadLong) {
  const RunSummary s =
      run_plain(plain(wall_across, {"robot.faults=[{type: long, array: front, by_m: 1.5}]", dropouts}));
  EXPECT_EQ(s.collision_cause, "A4_range") << s.outcome_text;
}

TEST(CollisionCause, A6ADriveThatHardlyBrakes) {
  int collisions = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {  // about one in five collides
    const Scenario scenario =
        load_scenario(test::project_data_dir() / "scenarios" / "obstacles.yaml",
                      {"robot.acceleration_share=0.15", dropouts, "duration_s=40"}, seed);
    const RunSummary s = test::run(scenario, PerceptionLevel::geometric).summary;
    if (s.outcome != Outcome::collision) continue;
    ++collisions;
    EXPECT_EQ(s.collision_cause, "A6_drive") << seed << ": " << s.outcome_text;
  }
  EXPECT_GE(collisions, 1);
}

/// A robot that drove straight ahead into the wall across, at a steady 0.3 m/s; what its odometry made of
/// every metre.
CollisionEvidence straight_into(const std::string& touched, double odometry_scale) {
  CollisionEvidence evidence;
  evidence.touched = touched;
  for (long k = 0;; ++k) {
    StepRecord step;
    step.step = k;
    step.time_s = 0.02 * static_cast<double>(k);
    step.pose.x_m = 0.3 * step.time_s;
    step.odometry.x_m = odometry_scale * step.pose.x_m;
    step.twist = step.control.command = {0.3, 0.0};
    evidence.steps.push_back(step);
    if (step.pose.x_m > 1.9 - pioneer_3dx_footprint.front_m) return evidence;
  }
}

TEST(CollisionCause, A5OdometryBeyondItsBound) {
  const Scenario scenario = plain(wall_across, {dropouts});
  EXPECT_EQ(collision_cause(scenario, straight_into("block", 0.97)), "A5_odometry");
  EXPECT_EQ(collision_cause(scenario, straight_into("block", 0.995)), "none_broken") << "the bound is 1 %";
}

TEST(CollisionCause, A6ADriveThatEndsElsewhereThanItsModelSays) {
  const Scenario scenario = plain(wall_across, {dropouts});
  const auto strayed_by = [&](double stray_m) {
    CollisionEvidence evidence = straight_into("block", 1.0);
    evidence.steps.back().pose.x_m += stray_m;
    evidence.steps.back().odometry.x_m += stray_m;
    return collision_cause(scenario, evidence);
  };
  EXPECT_EQ(strayed_by(0.02), "A6_drive");
  EXPECT_EQ(strayed_by(0.003), "none_broken") << "the model's own error is 1 cm";
}

TEST(CollisionCause, A7SomethingNearTheStart) {
  const Scenario scenario = plain(wall_across, {"avoidance.start_clear_m=2.5", dropouts});
  EXPECT_EQ(collision_cause(scenario, straight_into("block", 1.0)), "A7_start");
}

TEST(CollisionCause, A8CreepingAway) {
  const Scenario scenario = plain(wall_across, {dropouts});
  CollisionEvidence evidence = straight_into("block", 1.0);
  evidence.steps[evidence.steps.size() - 20].control.shield = creeping_reason;
  EXPECT_EQ(collision_cause(scenario, evidence), "A8_creep");
}

TEST(CollisionCause, OneMissedEchoExplainsNothingTwoInARowDo) {
  const Scenario scenario = plain(wall_across, {dropouts});
  CollisionEvidence evidence = straight_into("block", 1.0);
  const auto fire = [&](double time_s, double range_m) {
    evidence.firings.push_back({{0.3 * time_s, 0, 0}, {time_s, 3, range_m, range_m < 5}});
  };
  fire(3.0, 5.0);
  fire(3.32, 0.7);
  EXPECT_EQ(collision_cause(scenario, evidence), "none_broken");
  fire(3.64, 5.0);
  fire(3.96, 5.0);
  EXPECT_EQ(collision_cause(scenario, evidence), "A3_echo");
  const Scenario faulty = plain(wall_across, {"robot.faults=[{type: stuck, sonar: 3, from_s: 3.5}]"});
  EXPECT_EQ(collision_cause(faulty, evidence), "A4_range");
  const Scenario other = plain(wall_across, {"robot.faults=[{type: stuck, sonar: 4, from_s: 3.5}]"});
  EXPECT_EQ(collision_cause(other, evidence), "A3_echo") << "the fault is another's";
}

TEST(CollisionCause, RestDoesNotMakeFreeSpaceForgotten) {
  const Scenario scenario = plain(wall_across, {dropouts});
  CollisionEvidence evidence = straight_into("block", 1.0);
  for (const double time_s : {3.0, 3.32})
    evidence.firings.push_back({{0.3 * time_s, 0, 0}, {time_s, 3, 5.0, false}});
  ASSERT_EQ(collision_cause(scenario, evidence), "A3_echo");
  // A hundred seconds of standing at four seconds, more than the memory.
  for (std::size_t k = 200; k < evidence.steps.size(); ++k) evidence.steps[k].time_s += 100;
  evidence.steps[200].twist = {};
  EXPECT_EQ(collision_cause(scenario, evidence), "A3_echo");
  evidence.steps[200].twist = {0.0, 1e-3};
  EXPECT_NE(collision_cause(scenario, evidence), "A3_echo") << "in motion it is forgotten";
}

}  // namespace
}  // namespace ballservo
