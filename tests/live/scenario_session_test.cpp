// A run that is touched, without any browser.
#include "app/live/scenario_session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <future>
#include <thread>

#include "app/experiment/run_log.hpp"
#include "app/live/client_words.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using namespace std::chrono_literals;

class ScenarioSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    options.perception = PerceptionLevel::geometric;
    options.keep = [this](const RunRecord& run, const Touches& touches) {
      logs.push_back(log_csv(run.steps));
      kept.push_back(touches);
    };
    session = std::make_unique<ScenarioSession>(scenario, options, exchange);
    thread = std::thread([this] { session->run(); });
    until([this] { return exchange.newest() != nullptr; });
  }
  void TearDown() override { end(); }
  void end() {
    if (!thread.joinable()) return;
    ask({{"do", "end"}});
    thread.join();
  }
  static void until(const std::function<bool()>& what) {
    while (!what()) std::this_thread::sleep_for(1ms);
  }
  Json ask(const Json& what) {
    std::promise<Json> answer;
    exchange.put({what, [&](const Json& said) { answer.set_value(said); }});
    return answer.get_future().get();
  }
  Json touch(const Json& what) { return ask({{"do", "touch"}, {"touch", what}}); }
  Json state() { return Json::parse(exchange.newest()->state); }

  Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "obstacles.yaml", {}, 3);
  ScenarioSessionOptions options;
  LiveExchange exchange;
  std::vector<std::string> logs;
  std::vector<Touches> kept;
  std::unique_ptr<ScenarioSession> session;
  std::thread thread;
};

TEST_F(ScenarioSessionTest, WhatIsTouchedIsSeenAndKept) {
  EXPECT_FALSE(touch({{"do", "ball"}, {"x_m", 2.0}, {"y_m", -1.0}}).contains("refused"));
  until([this] { return state()["balls"][0]["center"] == Json({2.0, -1.0}); });
  EXPECT_FALSE(touch({{"do", "law"}, {"name", "pose"}}).contains("refused"));
  until([this] { return state()["law"] == "pose"; });
  const std::size_t obstacles = state()["obstacles"].size();
  touch({{"do", "box"}, {"x_m", 5.0}, {"y_m", 2.0}});
  until([&] { return state()["obstacles"].size() == obstacles + 1; });
  until([&] { return state()["step"] > 100; });
  end();
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept[0].list.size(), 3u);

  RunOptions again;
  again.perception = options.perception;
  again.touch = replay(kept[0]);
  scenario.duration_s = kept[0].duration_s(scenario);
  EXPECT_EQ(log_csv(run_closed_loop(scenario, again).steps), logs[0]);
}

TEST_F(ScenarioSessionTest, WhatCannotBeDoneIsRefusedWithItsReason) {
  EXPECT_THAT(touch({{"do", "ball"}, {"x_m", 99}, {"y_m", 0}})["refused"], HasSubstr("x_m"));
  EXPECT_THAT(touch({{"do", "obstacle"}, {"name", "nobody"}, {"x_m", 1}, {"y_m", 0}})["refused"],
              HasSubstr("nobody"));
  for (const Json& refused :
       {touch({{"do", "dance"}}), touch({{"do", "light"}, {"factor", "much"}}), touch(7),
        touch({{"do", "gain"}, {"per_s", 1}, {"step", 3}}), ask({{"do", "touch"}}),
        ask({{"do", "speed"}, {"factor", 0}}), ask({{"do", "teach"}})})
    EXPECT_TRUE(refused.contains("refused")) << refused;
  EXPECT_EQ(state()["touches"], 0);
}

TEST_F(ScenarioSessionTest, PausesStepsAndBeginsAnew) {
  ask({{"do", "pause"}});
  const long before = state()["step"];
  ask({{"do", "step"}});
  until([&] { return state()["step"] == before + 1; });
  touch({{"do", "ball"}, {"x_m", 2.0}, {"y_m", 0.5}});
  EXPECT_EQ(state()["balls"][0]["center"], Json({2.0, 0.5})) << "seen while nothing moves";
  EXPECT_EQ(state()["step"], before + 1);
  ask({{"do", "reset"}});
  until([&] { return session->runs() == 2 && state()["touches"] == 0; });
  EXPECT_EQ(state()["balls"][0]["center"][0], scenario.target_ball().p_WB(0).x());
}

TEST_F(ScenarioSessionTest, StaysAsItEndedUntilItBeginsAnew) {
  const Json robot = state()["robot"];
  touch({{"do", "box"}, {"x_m", robot[0]}, {"y_m", robot[1]}});
  until([this] { return state()["outcome"] == "collision"; });
  EXPECT_TRUE(touch({{"do", "light"}, {"factor", 1}}).contains("refused"));
  EXPECT_FALSE(ask({{"do", "save"}}).contains("refused"));
  ask({{"do", "reset"}});
  until([this] { return state()["outcome"] == ""; });
}

TEST_F(ScenarioSessionTest, ShowsWhatTheCameraSees) {
  exchange.set_views({"picture"});
  until([this] { return state()["step"] > 20 && !state()["free"].is_null(); });
  cv::Mat picture;
  until([&] { return !(picture = exchange.newest()->draw("picture")).empty(); });
  EXPECT_EQ(picture.cols, scenario.camera.camera.size().width_px);
  EXPECT_TRUE(exchange.newest()->draw("votes").empty());
  EXPECT_FALSE(state()["beams"].empty());
}

TEST_F(ScenarioSessionTest, WhatIsSentDoesNotGrowWithTheRun) {
  end();
  options.trail_s = 1;
  options.keep = {};
  session = std::make_unique<ScenarioSession>(scenario, options, exchange);
  thread = std::thread([this] { session->run(); });
  until([this] { return state()["step"] < 50; });
  ask({{"do", "speed"}, {"factor", 4}});
  until([this] { return state()["step"] > 200; });
  const Json robot = state()["robot"], trail = state()["trail"];
  EXPECT_LE(trail.size(), 7u);
  EXPECT_NEAR(trail.back()[0], robot[0], 0.2);
  const std::string saved = from_base64(ask({{"do", "save"}})["base64"]).value_or("");
  EXPECT_GT(std::stol(saved.substr(saved.find("steps: ") + 7)), 200) << "not those that are remembered";
}

TEST_F(ScenarioSessionTest, ARunThatForgetsKeepsItsLastSteps) {
  end();
  std::size_t most_steps = 0, most_firings = 0;
  RunOptions endless;
  endless.perception = options.perception;
  endless.remembered_steps = 100;
  endless.touch = [&](const RunView& now) -> std::vector<Touch> {
    most_steps = std::max({most_steps, now.record.steps.size(), now.record.frames.size()});
    most_firings = std::max(most_firings, now.firings.size());
    return {};
  };
  scenario.duration_s = 20;
  const RunRecord run = run_closed_loop(scenario, endless);
  EXPECT_EQ(run.steps.back().step, 1000);
  EXPECT_LE(most_steps, 200u);
  EXPECT_LE(most_firings, 210u);
  EXPECT_LE(run.timing.control_us.size(), 200u);
  EXPECT_LT(run.tracks_csv.size(), 1000u);
}

TEST_F(ScenarioSessionTest, AFloodOfCommandsHoldsNothingUp) {
  std::atomic<bool> over{false};
  const std::function<void()> say = [&] {  // and again as soon as it is answered
    if (!over) exchange.put({{{"do", "dance"}}, [&](const Json&) { say(); }});
  };
  say();
  const long step = state()["step"];
  until([&] { return state()["step"] > step + 20; });
  over = true;
  ask({{"do", "dance"}});  // before which one more may have been put
  ask({{"do", "dance"}});
}

}  // namespace
}  // namespace ballservo
