// A camera calibrated in the page, from a folder in which each picture of a board stands still for a while.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "app/commands/command.hpp"
#include "app/live/footage_session.hpp"
#include "calibration/camera/files/camera_file.hpp"
#include "tests/support/test_data.hpp"

namespace ballservo {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;
using namespace std::chrono_literals;

constexpr int boards = 4;
constexpr int repeats = 8;
constexpr int ball_u_px = 600, ball_v_px = 440, ball_radius_px = 24;  // where no board is

// Shaded, since through the lens of these pictures a round disc is a flat oval.
void draw_ball(cv::Mat& bgr) {
  for (int radius_px = ball_radius_px; radius_px > 0; --radius_px) {
    const int inward_px = ball_radius_px - radius_px, towards_light_px = inward_px / 3;
    cv::circle(bgr, {ball_u_px - towards_light_px, ball_v_px - towards_light_px}, radius_px,
               cv::Scalar(24, 108, 24) * (1 + 0.7 * inward_px / ball_radius_px), cv::FILLED, cv::LINE_AA);
  }
}

class BoardSessionTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto examples = test::opencv_doc_dir();
    if (!examples) GTEST_SKIP() << "OpenCV's example pictures are not here";
    std::filesystem::create_directory(folder());
    for (int number = 1; number <= boards; ++number) {
      cv::Mat bgr = cv::imread((*examples / fmt::format("left{:02}.jpg", number)).string());
      draw_ball(bgr);
      const std::filesystem::path first = folder() / fmt::format("{}_0.png", number);
      cv::imwrite(first.string(), bgr);
      for (int i = 1; i < repeats; ++i)
        std::filesystem::create_hard_link(first, folder() / fmt::format("{}_{}.png", number, i));
    }
    FootageOptions options;
    options.source = folder().string();
    options.max_pixels = 1e7;
    options.fps = 10;
    options.camera_output = camera_file();
    BallOptions balls;
    balls.taught = false;
    balls.diameter = "0.07";
    session = std::make_unique<FootageSession>(options, DetectorFactory(balls, CommonOptions()), exchange);
    thread = std::thread([this] { session->run(); });
    until([&] { return exchange.newest() != nullptr; });
  }
  void TearDown() override {
    if (!thread.joinable()) return;
    ask({{"do", "end"}});
    thread.join();
  }

  std::filesystem::path folder() const { return temporary.path() / "boards"; }
  std::filesystem::path camera_file() const { return temporary.path() / "camera.yaml"; }
  Json ask(const Json& what) {
    std::promise<Json> answer;
    exchange.put({what, [&](const Json& said) {
                    if (said["answer"] != "found") answer.set_value(said);
                  }});
    return answer.get_future().get();
  }
  Json state() { return Json::parse(exchange.newest()->state); }
  Json calibration() { return state()["calibration"]; }
  template <class What>
  void until(const What& what) {
    const auto end = std::chrono::steady_clock::now() + 400s;
    while (!what()) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << calibration();
      std::this_thread::sleep_for(5ms);
    }
  }

  /// Picture by picture, each searched before the next is shown: however slow the machine is.
  template <class What>
  void step_until(const What& what) {
    for (int step = 0; !what(); ++step) {
      ASSERT_LT(step, 20 * boards * repeats) << calibration();
      const long searched = calibration()["searched"];
      ask({{"do", "step"}});
      until([&] { return calibration()["searched"] > searched; });
    }
  }

  test::TemporaryFolder temporary;
  LiveExchange exchange;
  std::unique_ptr<FootageSession> session;
  std::thread thread;
};

TEST_F(BoardSessionTest, BoardsAreTakenACameraIsFittedSavedAndUsed) {
  EXPECT_EQ(calibration()["on"], false);
  EXPECT_THAT(ask({{"do", "calibrate_undo"}})["refused"], HasSubstr("Start"));
  EXPECT_THAT(ask({{"do", "save_camera"}})["refused"], HasSubstr("0 pictures"));
  EXPECT_THAT(ask({{"do", "calibrate"}, {"board", "chessboard:9"}, {"square_m", 0.025}})["refused"],
              HasSubstr("chessboard:9x6"));
  EXPECT_THAT(ask({{"do", "calibrate"}, {"board", "chessboard:9x6"}})["refused"],
              HasSubstr("allowed: 1 to 1000 mm"));
  const Json taught = ask({{"do", "teach"},
                           {"serial", exchange.newest()->serial},
                           {"u_px", ball_u_px},
                           {"v_px", ball_v_px},
                           {"radius_px", ball_radius_px},
                           {"name", "ball"}});
  ASSERT_FALSE(taught.contains("refused")) << taught;
  until([&] { return !state()["balls"].empty(); });
  EXPECT_TRUE(state()["balls"][0]["p_m"].is_null()) << "no camera yet";

  ask({{"do", "pause"}});
  ASSERT_FALSE(
      ask({{"do", "calibrate"}, {"board", "chessboard:9x6"}, {"square_m", 0.025}}).contains("refused"));
  until([&] { return calibration()["on"] == true; });
  step_until([&] { return calibration()["taken"] == 1; });
  EXPECT_EQ(calibration()["corners_px"].size(), 54u);
  EXPECT_THAT(ask({{"do", "save_camera"}})["refused"], HasSubstr("4 are the least"));
  step_until([&] { return calibration()["taken"] == 2; });
  ASSERT_FALSE(ask({{"do", "calibrate_undo"}}).contains("refused"));
  until([&] { return calibration()["taken"] == 1; });
  step_until([&] { return calibration()["taken"] == boards; });
  until([&] { return calibration()["fitting"] == false; });
  ask({{"do", "calibrate_stop"}});
  until([&] { return calibration()["on"] == false; });
  ask({{"do", "calibrate_go_on"}});
  until([&] { return calibration()["on"] == true; });
  EXPECT_EQ(calibration()["taken"], boards);

  const Json fit = calibration()["fit"];
  ASSERT_EQ(fit["refused"], "") << fit;
  EXPECT_EQ(fit["boards"], boards);
  EXPECT_LT(fit["rms_px"], 0.5);
  EXPECT_LT(fit["covered_ball_sigma_mm"], 20);
  EXPECT_EQ(fit["map"]["sigma_mm"].size(),
            fit["map"]["columns"].get<std::size_t>() * fit["map"]["rows"].get<std::size_t>());
  const Json saved = ask({{"do", "save_camera"}});
  ASSERT_EQ(saved["saved"], camera_file().string()) << saved;
  until([&] { return calibration()["on"] == false; });
  const KnownCamera camera = read_known_camera(camera_file().string());
  EXPECT_NEAR(camera.camera.focal_px(), 535, 10) << "as OpenCV's left_intrinsics.yml";
  EXPECT_TRUE(camera.covariance);
  until([&] { return !state()["balls"].empty(); });
  const Json ball = state()["balls"][0];
  ASSERT_FALSE(ball["p_m"].is_null()) << ball;
  const auto p_m = ball["p_m"].get<std::vector<double>>();
  EXPECT_NEAR(std::hypot(p_m[0], p_m[1], p_m[2]), 535 * 0.035 / ball_radius_px, 0.05);
  EXPECT_FALSE(ask({{"do", "save_camera"}}).contains("refused")) << "its own file is replaced";
  EXPECT_TRUE(state()["warnings"].empty()) << state()["warnings"];

  EXPECT_THAT(ask({{"do", "diameter"}, {"diameter_m", 7e-5}})["refused"],
              HasSubstr("0.07 mm; allowed: 1 to"));
  ASSERT_FALSE(ask({{"do", "diameter"}, {"diameter_m", 0.14}}).contains("refused"));
  until([&] { return calibration()["diameter"] == "0.14" && !state()["balls"].empty(); });
  const auto twice_m = state()["balls"][0]["p_m"].get<std::vector<double>>();
  EXPECT_NEAR(twice_m[2], 2 * p_m[2], 0.02 * p_m[2]);
}

}  // namespace
}  // namespace ballservo
