// Teaching by clicking, and why something is no ball, without any browser.
#include "app/live/footage_session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "app/commands/command.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/color/color_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using namespace std::chrono_literals;

class FootageSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto examples = test::opencv_doc_dir();
    if (!examples) GTEST_SKIP() << "OpenCV's example pictures are not here";
    start(*examples / "smarties.png");
  }
  void TearDown() override {
    if (!session) return;
    if (thread.joinable()) {
      ask({{"do", "end"}});
      thread.join();
    }
  }

  void start(const std::filesystem::path& source) {
    FootageOptions options;
    options.source = source.string();
    options.max_pixels = 1e7;
    options.colors_output = temporary.path() / "taught.colors";
    BallOptions balls;
    balls.taught = false;
    session = std::make_unique<FootageSession>(options, DetectorFactory(balls, CommonOptions()), exchange);
    thread = std::thread([this] { session->run(); });
    while (!exchange.newest()) std::this_thread::sleep_for(1ms);
  }
  Json ask(const Json& what) {
    std::promise<Json> answer;
    exchange.put({what, [&](const Json& said) {
                    if (said["answer"] == "found")
                      circle_found = said["circle_px"];
                    else
                      answer.set_value(said);
                  }});
    return answer.get_future().get();
  }
  Json state() { return Json::parse(exchange.newest()->state); }
  /// A click on what is shown now.
  Json click(const char* verb, double u_px, double v_px, double radius_px = 0, const std::string& name = "") {
    return ask({{"do", verb},
                {"serial", exchange.newest()->serial},
                {"u_px", u_px},
                {"v_px", v_px},
                {"radius_px", radius_px},
                {"name", name}});
  }
  /// Once so many pictures more have been shown.
  Json later(long pictures = 5) {
    const long until = state()["frame"].get<long>() + pictures;
    while (state()["frame"].get<long>() < until) std::this_thread::sleep_for(1ms);
    return state();
  }

  test::TemporaryFolder temporary;
  LiveExchange exchange;
  Json circle_found;  // the circle that the last lesson told of before it was over
  std::unique_ptr<FootageSession> session;
  std::thread thread;
};

// Where sweets of smarties.png are.
constexpr double green_u = 269, green_v = 117, red_u = 287, red_v = 213, sweet_radius_px = 26.5;

TEST_F(FootageSessionTest, AClickTeachesTheBallUnderIt) {
  EXPECT_TRUE(state()["classes"].empty());
  const Json taught = click("teach", green_u + 6, green_v - 5);
  ASSERT_FALSE(taught.contains("refused")) << taught;
  EXPECT_EQ(taught["class"], "green");
  EXPECT_NEAR(taught["circle_px"][0], green_u, 3);
  EXPECT_NEAR(taught["circle_px"][1], green_v, 3);
  EXPECT_NEAR(taught["circle_px"][2], sweet_radius_px, 3);
  EXPECT_EQ(circle_found, taught["circle_px"]);
  const Json seen = later();
  ASSERT_EQ(seen["classes"].size(), 1u);
  bool found = false;
  for (const Json& ball : seen["balls"])
    found |= std::hypot(ball["outline_px"][0].get<double>() - green_u,
                        ball["outline_px"][1].get<double>() - green_v) < 3;
  EXPECT_TRUE(found) << seen["balls"];
}

TEST_F(FootageSessionTest, EachLessonCanBeTakenBack) {
  click("teach", green_u, green_v);
  const Json red = click("teach", red_u, red_v, 0, "cherry");
  ASSERT_FALSE(red.contains("refused")) << red;
  EXPECT_EQ(state()["classes"].size(), 2u);
  EXPECT_EQ(state()["classes"][1]["name"], "cherry");
  ask({{"do", "undo"}});
  ASSERT_EQ(state()["classes"].size(), 1u);
  EXPECT_EQ(state()["classes"][0]["name"], "green");
  ask({{"do", "undo"}});
  EXPECT_TRUE(state()["classes"].empty());
  EXPECT_TRUE(state()["balls"].empty());
  EXPECT_THAT(ask({{"do", "undo"}})["refused"], HasSubstr("nothing to undo"));
}

TEST_F(FootageSessionTest, AnotherPictureOfTheSameClassIsAddedToIt) {
  click("teach", green_u, green_v);
  const Json again = click("teach", green_u, green_v, sweet_radius_px);
  ASSERT_FALSE(again.contains("refused")) << again;
  EXPECT_EQ(again["class"], "green") << "its colour is known";
  EXPECT_EQ(state()["classes"].size(), 1u);
}

TEST(ColorLessons, APictureIsSearchedOnceForAllItsLessons) {
  const auto examples = test::opencv_doc_dir();
  if (!examples) GTEST_SKIP() << "OpenCV's example pictures are not here";
  long tests = 0, found_after = 0;
  const auto count = [&] { ++tests; };
  std::string name;
  const auto lesson = [&](const ColorLessons& base, double u_px, double v_px) {
    static const cv::Mat bgr = cv::imread((*examples / "smarties.png").string());
    return base.with(
        {bgr, {{u_px, v_px}, 0}, ""}, count, [&](const PointedBall&) { found_after = tests; }, name);
  };
  const ColorLessons green = lesson({}, green_u, green_v);
  EXPECT_GT(tests, 0);
  EXPECT_EQ(found_after, tests) << "learning searched again";
  const long once = tests;
  EXPECT_EQ(lesson(green, red_u, red_v).table()->classes.size(), 2u);
  EXPECT_EQ(tests, once);
}

TEST_F(FootageSessionTest, WhatCannotBeLearntIsRefusedInPlace) {
  for (const Json& refused :
       {click("teach", -50, 10), click("teach", 5, 5), click("teach", 5, 5, 3),
        click("teach", green_u, green_v, 0, "No Name!"), click("rename", 0, 0), ask({{"do", "teach"}}),
        ask({{"do", "why"}}), ask({{"do", "dance"}}), ask({{"do", "record"}}), ask({{"do", "save"}}),
        ask({{"do", "load"}, {"base64", "AAAA"}})})
    EXPECT_TRUE(refused.contains("refused")) << refused;
  EXPECT_TRUE(state()["classes"].empty());
  EXPECT_FALSE(click("teach", green_u, green_v).contains("refused"));
}

TEST_F(FootageSessionTest, SaysWhySomethingIsNoBall) {
  click("teach", green_u, green_v);
  const Json background = click("why", 5, 5);
  EXPECT_EQ(background["ball"], false);
  EXPECT_THAT(background["text"], HasSubstr("no class"));
  EXPECT_THAT(background["remedy"], HasSubstr("teach the colour anew"));
  const Json ball = click("why", green_u, green_v);
  EXPECT_EQ(ball["ball"], true) << ball;
  EXPECT_THAT(ball["figures"], HasSubstr("of the outline"));
}

TEST_F(FootageSessionTest, WhatIsSavedIsLoadedAgain) {
  click("teach", green_u, green_v);
  click("teach", red_u, red_v);
  EXPECT_FALSE(ask({{"do", "save"}}).contains("refused"));
  const ColorTable saved = read_color_file(temporary.path() / "taught.colors");
  EXPECT_EQ(saved.classes.size(), 2u);
  EXPECT_FALSE(ask({{"do", "rename"}, {"class", "green"}, {"name", "leaf"}}).contains("refused"));
  EXPECT_EQ(state()["classes"][0]["name"], "leaf");
  EXPECT_FALSE(ask({{"do", "save"}}).contains("refused")) << "its own file is replaced";
  EXPECT_TRUE(read_color_file(temporary.path() / "taught.colors").find("leaf"));
}

TEST_F(FootageSessionTest, PausedItLooksAgainAtWhatIsTaught) {
  ask({{"do", "pause"}});
  const Json before = state();
  EXPECT_EQ(before["paused"], true);
  click("teach", green_u, green_v);
  EXPECT_EQ(state()["frame"], before["frame"]);
  EXPECT_FALSE(state()["balls"].empty());
  ask({{"do", "step"}});
  while (state()["frame"] == before["frame"]) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(state()["frame"].get<long>(), before["frame"].get<long>() + 1);
}

TEST_F(FootageSessionTest, StagesAreMadeOfAPictureThatStandsStill) {
  click("teach", green_u, green_v);
  ask({{"do", "pause"}});
  EXPECT_FALSE(state().contains("candidates"));
  exchange.set_views({"candidates"});
  for (int wait = 0; wait < 2000 && !state().contains("candidates"); ++wait) std::this_thread::sleep_for(1ms);
  EXPECT_FALSE(state()["candidates"].empty());
}

TEST_F(FootageSessionTest, StagesAreMadeForWhoLooksAtThem) {
  click("teach", green_u, green_v);
  EXPECT_FALSE(later(2).contains("candidates"));
  exchange.set_views({"candidates"});
  const Json seen = later(2);
  ASSERT_TRUE(seen.contains("candidates"));
  EXPECT_FALSE(seen["candidates"].empty());
  for (const char* view :
       {"picture", "taught", "classified", "opened", "closed", "votes", "edges", "candidates", "refined"})
    EXPECT_FALSE(exchange.newest()->draw(view).empty()) << view;
  EXPECT_TRUE(exchange.newest()->draw("no such").empty());
}

TEST_F(FootageSessionTest, AFloodOfCommandsHoldsNothingUp) {
  std::atomic<bool> over{false};
  const std::function<void()> say = [&] {  // and again as soon as it is answered
    if (!over) exchange.put({{{"do", "dance"}}, [&](const Json&) { say(); }});
  };
  say();
  later();
  over = true;
  ask({{"do", "dance"}});  // before which one more may have been put
  ask({{"do", "dance"}});
}

}  // namespace
}  // namespace ballservo
