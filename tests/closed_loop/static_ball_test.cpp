#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <opencv2/core/utility.hpp>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

using test::bytes_of;
using test::run;
using test::static_ball;

constexpr double degree = 0.017453292519943295;

void expect_reached(const RunRecord& record, double range_m, double bearing_rad, const std::string& name) {
  const RunSummary& s = record.summary;
  EXPECT_EQ(s.outcome, Outcome::reached) << name << ": " << s.outcome_text;
  EXPECT_LE(std::abs(s.range_error_m), range_m) << name;
  EXPECT_LE(std::abs(s.bearing_error_rad), bearing_rad) << name;
  EXPECT_EQ(s.lost_events, 0) << name;
  EXPECT_EQ(s.ball_contacts, 0) << name;
  EXPECT_EQ(s.collision_cause, "") << name;
  EXPECT_GE(s.settled_s, s.time_optimal_s) << name;
  EXPECT_LE(s.settled_s, 1.4 * s.time_optimal_s + 0.5) << name;
}

class Perception : public testing::TestWithParam<PerceptionLevel> {};

TEST_P(Perception, EveryLawReachesTheBallFromEverySeed) {
  for (const std::string& law : builtin_laws().names()) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const RunRecord record = run(static_ball(seed, {"law.name=" + law}), GetParam());
      expect_reached(record, 0.001, 0.05 * degree, law + ", seed " + std::to_string(seed));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(WithoutPictures, Perception,
                         testing::Values(PerceptionLevel::truth, PerceptionLevel::geometric),
                         [](const auto& tested) { return std::string(perception_level_name(tested.param)); });

TEST(StaticBall, IsReachedThroughRenderedFrames) {
  expect_reached(run(static_ball(0), PerceptionLevel::image), 0.005, 0.2 * degree, "seed 0");
}

TEST(StaticBall, IsReachedInALightThatItsColorsWereNotTaughtIn) {
  const RunRecord record = run(static_ball(0, {"light_level=0.4"}), PerceptionLevel::image);
  EXPECT_EQ(record.summary.outcome, Outcome::reached) << record.summary.outcome_text;
  EXPECT_TRUE(record.assumed_light);
}

TEST(StaticBall, TheFirstFramesMeasureTheRadiusToo) {
  double sum_px = 0;
  int count = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const Scenario scenario = static_ball(seed, {"duration_s=0.4"});
    const RunRecord record = run(scenario, PerceptionLevel::image);
    for (const FrameRecord& frame : record.frames) {
      if (frame.measurement.state != TrackState::confirmed) continue;
      const double truth_m = frame.truth_p_CB->norm(), error_m = frame.measurement.p_CB.norm() - truth_m;
      const double radius_px =
          scenario.target_ball().radius_m() / truth_m * scenario.camera.camera.focal_px();
      sum_px -= error_m / truth_m * radius_px;
      ++count;
    }
  }
  ASSERT_GE(count, 20);
  EXPECT_NEAR(sum_px / count, 0, 0.1);
}

TEST(StaticBall, LawsStopAtTheSamePlace) {
  const RunRecord cone = run(static_ball(3, {"law.name=cone"}), PerceptionLevel::truth);
  const RunRecord visp = run(static_ball(3, {"law.name=visp"}), PerceptionLevel::truth);
  const Pose2 a = cone.steps.back().pose, b = visp.steps.back().pose;
  EXPECT_NEAR(a.x_m, b.x_m, 0.002);
  EXPECT_NEAR(a.y_m, b.y_m, 0.002);
}

TEST(StaticBall, SlowCameraAndLongDelaysAreBrakedFor) {
  for (const std::string latency : {"0.0", "0.1", "0.2"}) {
    const RunRecord record = run(
        static_ball(1, {"camera.latency_s=" + latency, "camera.rate_hz=15", "robot.actuation_delay_s=0.15"}),
        PerceptionLevel::geometric);
    EXPECT_EQ(record.summary.outcome, Outcome::reached) << latency;
    for (const StepRecord& step : record.steps) EXPECT_GT(step.range_error_m, -0.005) << latency;
  }
}

TEST(StaticBall, ABallBehindTheRobotIsSearchedFor) {
  const RunRecord record =
      run(static_ball(0, {"robot.pose.yaw_rad=2.8", "robot.pose.x_m=1.0"}), PerceptionLevel::geometric);
  EXPECT_EQ(record.summary.outcome, Outcome::reached) << record.summary.outcome_text;
  EXPECT_GT(record.summary.out_of_view_s, 1.0);
}

TEST(StaticBall, ARunWithoutTimeEndsInTimeout) {
  const RunRecord record = run(static_ball(0, {"duration_s=2"}), PerceptionLevel::truth);
  EXPECT_EQ(record.summary.outcome, Outcome::timeout);
  EXPECT_NEAR(record.steps.back().time_s, 2.0, 1e-9);
  EXPECT_TRUE(std::isnan(record.summary.settled_s));
}

TEST(StaticBall, AnObstacleOnTheWayIsACollision) {
  const RunRecord record =
      run(static_ball(
              0, {"balls.0.position.x_m=3.0", "balls.0.position.y_m=0.0", "robot.pose.yaw_rad=0",
                  "obstacles=[{type: box, name: step, position: {x_m: 1.2, y_m: 0.0}, size: {x_m: 0.2, y_m: "
                  "0.4, z_m: 0.05}}]"}),
          PerceptionLevel::truth);
  EXPECT_EQ(record.summary.outcome, Outcome::collision) << record.summary.outcome_text;
  EXPECT_EQ(record.summary.collision_cause, "A1_shield");
  EXPECT_EQ(record.summary.min_clearance_m, 0);
}

TEST(StaticBall, AnInterruptedRunSaysSo) {
  RunOptions options;
  options.perception = PerceptionLevel::truth;
  options.go_on = [](double time_s) { return time_s < 1.5; };
  const RunRecord record = run_closed_loop(static_ball(0), options);
  EXPECT_EQ(record.summary.outcome, Outcome::interrupted);
  EXPECT_NEAR(record.steps.back().time_s, 1.5, 1e-9);
}

TEST(Replay, TheSameSeedGivesTheSameBytesAndAnotherDoesNot) {
  const std::string once = bytes_of(run(static_ball(5), PerceptionLevel::geometric));
  EXPECT_EQ(once, bytes_of(run(static_ball(5), PerceptionLevel::geometric)));
  EXPECT_NE(once, bytes_of(run(static_ball(6), PerceptionLevel::geometric)));
}

/// A German locale for the scope of a test: numbers have a decimal comma there.
class GermanLocale {
 public:
  GermanLocale() : taken_(std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr) {}
  ~GermanLocale() { std::setlocale(LC_ALL, "C"); }
  GermanLocale(const GermanLocale&) = delete;
  GermanLocale& operator=(const GermanLocale&) = delete;
  bool taken() const { return taken_; }

 private:
  bool taken_;
};

TEST(Replay, AGermanLocaleChangesNothing) {
  const std::string plain = bytes_of(run(static_ball(7), PerceptionLevel::geometric));
  std::string german;
  {
    const GermanLocale locale;
    ASSERT_TRUE(locale.taken()) << "de_DE.UTF-8 is missing: localedef -i de_DE -f UTF-8 de_DE.UTF-8";
    ASSERT_STREQ(std::localeconv()->decimal_point, ",");
    german = bytes_of(run(static_ball(7), PerceptionLevel::geometric));
  }
  EXPECT_EQ(plain, german);
}

TEST(Replay, PicturesGiveTheSameBytesAtOneAndTwoThreadsAndInAGermanLocale) {
  const Scenario scenario = static_ball(2, {"duration_s=1.5"});
  const int threads = cv::getNumThreads();
  cv::setNumThreads(1);
  const std::string one = bytes_of(run(scenario, PerceptionLevel::image));
  cv::setNumThreads(2);
  std::string two;
  {
    const GermanLocale locale;
    ASSERT_TRUE(locale.taken()) << "de_DE.UTF-8 is missing: localedef -i de_DE -f UTF-8 de_DE.UTF-8";
    two = bytes_of(run(static_ball(2, {"duration_s=1.5"}), PerceptionLevel::image));
  }
  cv::setNumThreads(threads);
  EXPECT_EQ(one, two);
}

}  // namespace
}  // namespace ballservo
