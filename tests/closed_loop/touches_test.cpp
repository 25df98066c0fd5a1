// A run that was touched, done again from its file: the same bytes.
#include "app/experiment/touches.hpp"

#include <gmock/gmock.h>

#include <fstream>

#include "calibration/base/fault.hpp"
#include "calibration/base/random.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

using Kind = Touch::Kind;
using testing::HasSubstr;

/// Anything that a hand may do now.
Touch any_touch(RandomEngine& engine, const RunView& now) {
  Touch touch;
  touch.step = now.record.steps.back().step;
  touch.kind = static_cast<Kind>(uniform_index(engine, 10));
  const Room& room = now.scenario.world.room;
  touch.to = {uniform(engine, 1.5, room.x_max_m - 0.5),
              uniform(engine, room.y_min_m + 0.5, room.y_max_m - 0.5), 0};
  const auto& obstacles = now.scenario.world.obstacles;
  switch (touch.kind) {
    case Kind::obstacle:
      touch.name = obstacles[uniform_index(engine, static_cast<std::uint32_t>(obstacles.size()))].name;
      break;
    case Kind::robot: {  // a small push
      const Pose2& pose = now.record.steps.back().pose;
      touch.to = {pose.x_m + uniform(engine, -0.1, 0.1), pose.y_m + uniform(engine, -0.1, 0.1),
                  pose.yaw_rad + uniform(engine, -0.3, 0.3)};
      break;
    }
    case Kind::law: {
      const auto names = builtin_laws().names();
      touch.name = names[uniform_index(engine, static_cast<std::uint32_t>(names.size()))];
      break;
    }
    case Kind::gain:
      touch.value = uniform(engine, 0.5, 3);
      break;
    case Kind::latency:
      touch.value = uniform(engine, 0, 0.2);
      break;
    case Kind::noise:
    case Kind::light:
      touch.value = uniform(engine, 0.3, 3);
      break;
    case Kind::avoidance:
      touch.avoidance = static_cast<AvoidanceOptions::Type>(
          uniform_index(engine, static_cast<std::uint32_t>(now.scenario.avoidance.type) + 1));
      break;
    default:
      break;
  }
  return touch;
}

class TouchedRun : public testing::Test {
 protected:
  /// Touches a run 30 times, and does so again from the file that this gives.
  void touch_and_replay(const char* name, PerceptionLevel level, long steps) {
    const std::filesystem::path file = test::project_data_dir() / "scenarios" / name;
    Scenario scenario = load_scenario(file, {}, 3);
    RunOptions options;
    options.perception = level;
    if (level == PerceptionLevel::image)
      options.colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
    Touches touches{steps, {}};
    scenario.duration_s = touches.duration_s(scenario);
    RandomEngine engine = random_stream(7, name);
    options.touch = [&](const RunView& now) {
      std::vector<Touch> now_done;
      if (touches.list.size() < 30 && now.record.steps.back().step % (steps / 31) == 0) {
        now_done.push_back(any_touch(engine, now));
        touches.list.push_back(now_done.back());
      }
      return now_done;
    };
    const RunRecord live = run_closed_loop(scenario, options);
    touches.steps = static_cast<long>(live.steps.size());  // something may have been run into
    ASSERT_GE(touches.list.size(), 20u);

    const auto written = folder.path() / "touches.yaml";
    std::ofstream(written) << touches_yaml(touches);
    Scenario again = load_scenario(file, {}, 3);
    const Touches read = read_touches(written, again);
    ASSERT_EQ(read.list.size(), touches.list.size());
    again.duration_s = read.duration_s(again);
    options.touch = replay(read);
    const RunRecord replayed = run_closed_loop(again, options);
    EXPECT_EQ(log_csv(replayed.steps), log_csv(live.steps));
    EXPECT_EQ(replayed.tracks_csv, live.tracks_csv);
    EXPECT_GT(live.tracks_csv.size(), 2000u);
  }
  Touches read(const std::string& text) {
    const auto file = folder.path() / "touches.yaml";
    std::ofstream(file) << text;
    return read_touches(file, test::static_ball(0));
  }

  test::TemporaryFolder folder;
};

TEST_F(TouchedRun, GivesTheSameBytesAgain) {
  touch_and_replay("obstacles.yaml", PerceptionLevel::geometric, 1500);
}

TEST_F(TouchedRun, GivesTheSameBytesAgainThroughPictures) {
  touch_and_replay("static_ball.yaml", PerceptionLevel::image, 220);
}

TEST_F(TouchedRun, FollowsABallThatIsMoved) {
  Scenario scenario = test::static_ball(0);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  Touch moved;
  moved.step = 700;
  moved.to = {1.5, 1.0, 0};
  const Touches touches{1500, {moved}};
  options.touch = replay(touches);
  scenario.duration_s = touches.duration_s(scenario);
  const RunRecord run = run_closed_loop(scenario, options);
  EXPECT_EQ(run.summary.outcome, Outcome::reached) << run.summary.outcome_text;
  EXPECT_EQ(run.steps.size(), 1500u);
  EXPECT_EQ(run.steps[700].p_WB.head<2>(), test::static_ball(0).target_ball().p_WB(0).head<2>());
  EXPECT_EQ(run.steps[701].p_WB.head<2>(), Eigen::Vector2d(1.5, 1.0));
  EXPECT_NEAR(run.summary.range_error_m, 0, 0.005);
}

TEST_F(TouchedRun, NothingDoneIsTheRunItself) {
  Scenario scenario = test::static_ball(1);
  RunOptions options;
  options.perception = PerceptionLevel::geometric;
  const RunRecord alone = run_closed_loop(scenario, options);
  scenario.duration_s = alone.steps.back().time_s;
  options.touch = replay({static_cast<long>(alone.steps.size()), {}});
  EXPECT_EQ(log_csv(run_closed_loop(scenario, options).steps), log_csv(alone.steps));
}

TEST_F(TouchedRun, EveryFaultIsNamedWithItsLine) {
  try {
    read(
        "steps: 100\n"
        "touches:\n"
        "  - {step: 5, do: ball, x_m: 1}\n"
        "  - {step: 4, do: ball, x_m: 1, y_m: 1}\n"
        "  - {step: 6, do: obstacle, name: nobody, x_m: 1, y_m: 1}\n"
        "  - {step: 7, do: ball, x_m: 99, y_m: 1}\n"
        "  - {step: 100, do: law, name: cone}\n"
        "  - {step: 8, do: law, name: none}\n"
        "  - {step: 9, do: gain, per_s: 0}\n"
        "  - {step: 9, do: dance}\n"
        "  - {step: 9, do: light, factor: 1, x_m: 2}\n"
        "  - {step: 9, do: avoidance, type: full}\n"
        "  - {step: 9, step: 9, do: light, factor: .nan}\n"
        "speed: 3\n");
    FAIL();
  } catch (const InputError& error) {
    std::string all;
    for (const Fault& fault : error.faults()) all += to_text(fault) + "\n";
    for (const char* line :
         {":3: ", ":5: ", ":6: ", ":7: ", ":8: ", ":9: ", ":10: ", ":11: ", ":12: ", ":13: ", ":14: "})
      EXPECT_THAT(all, HasSubstr("touches.yaml" + std::string(line)));
  }
  EXPECT_THROW(read("touches: []\n"), InputError);
  EXPECT_THROW(
      read("steps: 5\ntouches:\n  - {step: 3, do: light, factor: 1}\n  - {step: 2, do: light, factor: 1}\n"),
      InputError);
  EXPECT_EQ(read("steps: 5\n").list.size(), 0u);
  const Touches dropped = read(
      "steps: 50\ntouches:\n"
      "  - {step: 3, do: box, x_m: 1, y_m: 1}\n"
      "  - {step: 4, do: obstacle, name: dropped_1, x_m: 1.5, y_m: 1}\n");
  EXPECT_EQ(dropped.list.size(), 2u) << "what has been dropped can be moved";
}

}  // namespace
}  // namespace ballservo
