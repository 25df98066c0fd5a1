// Whole runs among obstacles, without pictures.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "app/scenario/feasibility.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

Scenario obstacles(std::uint64_t seed, const std::vector<std::string>& sets = {}) {
  return load_scenario(test::project_data_dir() / "scenarios" / "obstacles.yaml", sets, seed);
}

RunRecord run_geometric(const Scenario& scenario) { return test::run(scenario, PerceptionLevel::geometric); }

TEST(Obstacles, AreDrivenAroundAndNeverTouched) {
  int reached = 0;
  for (std::uint64_t seed = 100; seed < 112; ++seed) {
    const Scenario scenario = obstacles(seed);
    ASSERT_EQ(why_infeasible(scenario), "");
    const RunSummary s = run_geometric(scenario).summary;
    EXPECT_NE(s.outcome, Outcome::collision) << seed << ": " << s.outcome_text;
    EXPECT_GT(s.min_clearance_m, 0.0) << seed;
    EXPECT_EQ(s.collision_cause, "") << seed;
    reached += s.outcome == Outcome::reached ? 1 : 0;
  }
  EXPECT_GE(reached, 10);
}

TEST(Obstacles, ThingsThatMoveArePassedWhereTheyWillNotBe) {
  int reached = 0;
  for (std::uint64_t seed = 7000; seed < 7016; ++seed) {
    const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "movers.yaml", {}, seed);
    const RunSummary s = run_geometric(scenario).summary;
    EXPECT_NE(s.outcome, Outcome::collision) << seed << ": " << s.outcome_text;
    reached += s.outcome == Outcome::reached ? 1 : 0;
  }
  EXPECT_GE(reached, 11);
}

TEST(Obstacles, ABallBehindADeadEndOrAroundACornerIsFound) {
  int reached = 0;
  for (const char* file : {"dead_end.yaml", "corner.yaml"}) {
    for (std::uint64_t seed = 1; seed < 5; ++seed) {
      const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / file, {}, seed);
      ASSERT_EQ(why_infeasible(scenario), "") << file;
      const RunSummary s = run_geometric(scenario).summary;
      EXPECT_NE(s.outcome, Outcome::collision) << file << " " << seed;
      EXPECT_NE(s.outcome, Outcome::lost) << file << " " << seed << ": " << s.outcome_text;
      reached += s.outcome == Outcome::reached ? 1 : 0;
    }
  }
  EXPECT_GE(reached, 7);
}

TEST(Obstacles, WhereWallsHideAllBesideTheRobotItSetsOutBeforeAWholeTurn) {
  const Scenario corner = load_scenario(test::project_data_dir() / "scenarios" / "corner.yaml", {}, 3);
  const std::vector<StepRecord> steps = run_geometric(corner).steps;
  const auto sets_out = std::find_if(steps.begin(), steps.end(), [](const StepRecord& step) {
    return step.control.state == ControlState::explore;
  });
  ASSERT_NE(sets_out, steps.end());
  EXPECT_LT(sets_out->time_s, 8.0) << "a whole turn takes 11.6 s";
}

TEST(Obstacles, FromAnotherPlaceTheRobotTurnsToWhatItHasNotSeen) {
  double out_of_view_s = 0;
  for (const std::uint64_t seed : {30128, 30289, 30694, 31105, 31115, 31399}) {
    const RunSummary s = run_geometric(obstacles(seed)).summary;
    EXPECT_EQ(s.outcome, Outcome::reached) << seed;
    out_of_view_s += s.out_of_view_s;
  }
  EXPECT_LT(out_of_view_s, 40.0) << "93 with turns to any side, 8 to the right one";
}

TEST(Obstacles, AWayEndsAtRestAtItsGoal) {
  double nearest_m = 9;
  for (std::uint64_t seed = 1; seed < 9; ++seed) {
    const RunRecord run = run_geometric(obstacles(seed, {"law.name=visp"}));
    for (const StepRecord& step : run.steps) nearest_m = std::min(nearest_m, 0.8 + step.range_error_m);
  }
  EXPECT_GT(nearest_m, 0.7) << "0.8 m is wanted";
}

TEST(Obstacles, CorridorsAndDoorsAreDrivenThrough) {
  for (const char* file : {"corridor.yaml", "door.yaml", "poles.yaml"}) {
    int reached = 0;
    for (std::uint64_t seed = 1; seed < 5; ++seed) {
      const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / file, {}, seed);
      ASSERT_EQ(why_infeasible(scenario), "") << file;
      const RunSummary s = run_geometric(scenario).summary;
      EXPECT_NE(s.outcome, Outcome::collision) << file << " " << seed;
      reached += s.outcome == Outcome::reached ? 1 : 0;
    }
    EXPECT_GE(reached, 3) << file;
  }
}

TEST(Obstacles, WhereTheShieldRefusedOneWayAnotherIsTried) {
  // Without the memory of refused poses the robot tries the same way to the end of each of these runs.
  struct World {
    std::uint64_t seed;
    double yaw_rad, x_m, y_m;
  };
  int reached = 0;
  for (const World& world : {World{60931, 0.36239714631355746, 3.921791641976556, -0.9227123135821975},
                             World{61200, -0.12897461107781222, 4.8471596879941234, 0.28499644634032517},
                             World{61779, 0.3172437470856917, 4.819762532193066, -0.11139551461109343},
                             World{61913, -0.28071082752677223, 3.8138457320287324, -1.136247300217574},
                             World{62017, 0.17035577722266115, 4.010245869482006, 1.3193502905549983},
                             World{62035, 0.008830100827464882, 4.441665104792772, -1.0244378105434149}}) {
    const Scenario scenario = obstacles(world.seed, {fmt::format("robot.pose.yaw_rad={}", world.yaw_rad),
                                                     fmt::format("balls.0.position.x_m={}", world.x_m),
                                                     fmt::format("balls.0.position.y_m={}", world.y_m)});
    reached += run_geometric(scenario).summary.outcome == Outcome::reached ? 1 : 0;
  }
  EXPECT_GE(reached, 4);
}

TEST(Obstacles, TheLawAloneRunsIntoThem) {
  int collisions = 0;
  for (std::uint64_t seed = 100; seed < 140; ++seed) {
    const RunSummary s = run_geometric(obstacles(seed, {"avoidance.type=none"})).summary;
    if (s.outcome != Outcome::collision) continue;
    ++collisions;
    EXPECT_EQ(s.collision_cause, "A1_shield");
  }
  EXPECT_GE(collisions, 6);
}

TEST(Obstacles, ABlindRobotDoesNotMove) {
  for (const char* faults :
       {"robot.faults=[{type: dead, array: front}]", "robot.faults=[{type: late, array: front, by_s: 0.5}]",
        "robot.faults=[{type: dead, sonar: 3}]"}) {
    const RunRecord record = run_geometric(obstacles(100, {faults, "duration_s=10"}));
    for (const StepRecord& step : record.steps) EXPECT_LE(step.twist.v_mps, 1e-9) << faults << step.time_s;
  }
}

TEST(Obstacles, AnArrayThatFallsSilentStopsTheRobot) {
  const RunRecord record =
      run_geometric(obstacles(100, {"robot.faults=[{type: dead, array: front, from_s: 3}]", "duration_s=8"}));
  bool drove = false;
  for (const StepRecord& step : record.steps) {
    drove = drove || step.twist.v_mps > 0.2;
    // The last answer is heard up to 30 ms after 3 s; 120 ms of silence, a period, and no more.
    if (step.time_s <= 3.0 + 0.03 + 0.12 + 0.02) continue;
    EXPECT_LE(step.control.command.v_mps, 0.0) << step.time_s;
  }
  EXPECT_TRUE(drove);
}

TEST(Obstacles, LowThingsAreOutsideTheArgumentAndSaidToBe) {
  const RunSummary s =
      run_geometric(
          obstacles(0, {"obstacles=[{type: box, name: step, position: {x_m: 1.6, y_m: 0}, size: {x_m: 0.2, "
                        "y_m: 3.0, z_m: 0.05}}]",
                        "balls.0.position.y_m=0", "robot.pose.yaw_rad=0", "avoidance.floor=false"}))
          .summary;
  EXPECT_EQ(s.outcome, Outcome::collision);
  EXPECT_EQ(s.collision_cause, "A3_echo");
}

TEST(Feasibility, AWallAcrossTheRoomIsNot) {
  const Scenario closed = obstacles(0, {"obstacles=[{type: box, name: wall, position: {x_m: 1.6, y_m: 0}, "
                                        "size: {x_m: 0.2, y_m: 6.98, z_m: 1}}]"});
  EXPECT_NE(why_infeasible(closed), "");
  const Scenario open = obstacles(0, {"obstacles=[{type: box, name: wall, position: {x_m: 1.6, y_m: 0}, "
                                      "size: {x_m: 0.2, y_m: 4.5, z_m: 1}}]"});
  EXPECT_EQ(why_infeasible(open), "");
}

TEST(Feasibility, AGapIsJudgedByTheFootprint) {
  const auto with_gap = [](double gap_m) {
    const std::string size = "size: {x_m: 0.2, y_m: 3, z_m: 1}";
    const auto wall = [&](int side) {
      return fmt::format("{{type: box, name: wall{}, position: {{x_m: 1.6, y_m: {}}}, {}}}", side,
                         side * (0.5 * gap_m + 1.5), size);
    };
    return why_infeasible(obstacles(
        0, {fmt::format("obstacles=[{}, {}]", wall(-1), wall(1)), "room.y_min_m=-3.2", "room.y_max_m=3.2"}));
  };
  EXPECT_NE(with_gap(0.30), "") << "the robot is 0.425 m wide";
  EXPECT_EQ(with_gap(0.45), "");
}

TEST(Feasibility, APedestalDoesNotHideItsOwnBallButAWallAroundDoes) {
  const std::vector<std::string> ball{"balls.0.position.x_m=4", "balls.0.position.y_m=0"};
  std::vector<std::string> pedestal = ball, well = ball;
  pedestal.push_back("balls.0.position.z_m=0.36");
  pedestal.push_back(
      "obstacles=[{type: cylinder, name: pedestal, position: {x_m: 4, y_m: 0}, radius_m: 0.1, height_m: "
      "0.3}]");
  EXPECT_EQ(why_infeasible(obstacles(0, pedestal)), "");
  const auto wall = [](double x_m, double y_m, double along_x_m, double along_y_m) {
    return fmt::format(
        "{{type: box, name: wall_{}_{}, position: {{x_m: {}, y_m: {}}}, size: {{x_m: {}, y_m: {}, z_m: "
        "0.6}}}}",
        x_m, y_m, x_m, y_m, along_x_m, along_y_m);
  };
  well.push_back(fmt::format("obstacles=[{}, {}, {}, {}]", wall(3.6, 0, 0.05, 0.85), wall(4.4, 0, 0.05, 0.85),
                             wall(4, 0.4, 0.85, 0.05), wall(4, -0.4, 0.85, 0.05)));
  EXPECT_NE(why_infeasible(obstacles(0, well)), "");
}

TEST(Obstacles, TheSameSeedGivesTheSameBytes) {
  EXPECT_EQ(test::bytes_of(run_geometric(obstacles(7))), test::bytes_of(run_geometric(obstacles(7))));
}

}  // namespace
}  // namespace ballservo
