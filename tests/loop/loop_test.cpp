// The loop in one thread: what is called when, and how runs end.
#include "app/loop/loop.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibration/base/fault.hpp"
#include "tests/loop/test_ports.hpp"

namespace ballservo {
namespace {

/// Notes everything that it is told.
struct Notes final : LoopObserver {
  void frame(const FrameEvent& event) override {
    frames_s.push_back(event.frame.time_s);
    percept = event.percept;
  }
  void step(const StepEvent& event) override {
    steps_s.push_back(event.robot.time_s);
    heard.push_back(std::isfinite(event.perception_s));
    sees_ball.push_back(event.control.track_state != TrackState::none);
    skipped += event.skipped;
    if (throws) throw std::runtime_error("disk full");
  }
  void transition(const StepEvent& event, ControlState from) override {
    transitions.emplace_back(from, event.control.state);
  }
  std::vector<double> frames_s, steps_s;
  std::vector<bool> heard, sees_ball;
  std::vector<std::pair<ControlState, ControlState>> transitions;
  Percept percept;
  long skipped = 0;
  bool throws = false;
};

struct LoopTest : testing::Test {
  void run(double until_s) {
    run_loop({camera, perception, robot, controller, {&notes}}, clock,
             [until_s](double time_s) { return time_s < until_s; });
  }
  test::TestCamera camera;
  test::TestPerception perception;
  test::TestRobot robot;
  Controller controller = test::test_controller();
  SteppedClock clock;
  Notes notes;
};

TEST_F(LoopTest, StepsAtTheControllersRateAndLooksAtEveryFrameThatIsDue) {
  run(1);
  ASSERT_EQ(notes.steps_s.size(), 51u);
  for (std::size_t k = 0; k < notes.steps_s.size(); ++k) EXPECT_DOUBLE_EQ(notes.steps_s[k], 0.02 * k);
  ASSERT_EQ(notes.frames_s.size(), 100u);
  EXPECT_EQ(notes.skipped, 0);
  EXPECT_TRUE(robot.drove());
}

TEST_F(LoopTest, WhatATurnedCameraSeesIsTurned) {
  camera.pan_rad = 0.3;
  run(0.1);
  EXPECT_EQ(notes.percept.ball.pan_rad, 0.3);
  EXPECT_DOUBLE_EQ(notes.percept.floor.rays[0].bearing_rad, 0.3);
  EXPECT_DOUBLE_EQ(notes.percept.floor.rays[1].bearing_rad, 0.4);
  EXPECT_EQ(robot.panned.size(), robot.told.size()) << "at the end too";
}

TEST_F(LoopTest, ObserversHearOfEveryChangeOfState) {
  run(1);
  ASSERT_GE(notes.transitions.size(), 1u);
  EXPECT_EQ(notes.transitions.front().first, ControlState::search);
  EXPECT_EQ(notes.transitions.back().second, ControlState::approach);
  for (std::size_t k = 1; k < notes.transitions.size(); ++k)
    EXPECT_EQ(notes.transitions[k].first, notes.transitions[k - 1].second);
}

TEST_F(LoopTest, AFrameIsHeardOfWhenItArrivesAndNotBefore) {
  camera.latency_s = 0.1;
  run(0.2);
  for (std::size_t k = 0; k < notes.steps_s.size(); ++k) {
    // The first is exposed at 0.01 s.
    const bool arrived = notes.steps_s[k] >= 0.11;
    EXPECT_EQ(notes.heard[k], arrived) << notes.steps_s[k];
    EXPECT_EQ(notes.sees_ball[k], arrived) << notes.steps_s[k];
  }
}

TEST_F(LoopTest, StepsThatTheClockHasPassedAreLeftOut) {
  perception.works = [this] { clock.sleep_until(clock.now_s() + 0.05); };
  run(2);
  EXPECT_GT(notes.skipped, 20);
  // A step begins when perception is done with the frame before it: up to three periods late.
  EXPECT_NEAR(static_cast<double>(notes.steps_s.size()) + static_cast<double>(notes.skipped),
              notes.steps_s.back() / 0.02, 4);
}

TEST_F(LoopTest, WithoutFramesTheLawDoesNotDriveOn) {
  camera.lives_until_s = 0.6;
  run(2);
  EXPECT_TRUE(robot.drove());
  for (std::size_t k = 0; k < robot.told.size(); ++k) {
    if (robot.told_s[k] > 0.6 + 0.2 + 0.02 + 0.033) {
      EXPECT_EQ(robot.told[k].v_mps, 0.0) << robot.told_s[k];
    }
  }
}

TEST_F(LoopTest, WhateverEndsItTheRobotIsToldToRest) {
  run(1);
  EXPECT_TRUE(robot.rests());
  EXPECT_GT(robot.told.end()[-2].v_mps, 0) << "which it did not before";
}

TEST_F(LoopTest, AFaultOfTheCameraIsHandedOnAndTheRobotRests) {
  camera.lives_until_s = 0.6;
  camera.throws = true;
  EXPECT_THROW(run(1), std::runtime_error);
  EXPECT_TRUE(robot.drove());
  EXPECT_TRUE(robot.rests());
}

TEST_F(LoopTest, AFaultOfTheRobotIsHandedOnAndItIsToldToRestNevertheless) {
  robot.throws = true;
  EXPECT_THROW(run(1), std::runtime_error);
  EXPECT_TRUE(robot.rests());
}

TEST_F(LoopTest, AFaultOfAnObserverIsHandedOnAndTheRobotRests) {
  notes.throws = true;
  EXPECT_THROW(run(1), std::runtime_error);
  EXPECT_EQ(notes.steps_s.size(), 1u);
  EXPECT_TRUE(robot.rests());
}

TEST_F(LoopTest, AvoidanceAsksForSonars) {
  ControllerOptions options;
  options.avoidance.type = AvoidanceOptions::Type::shield;
  Controller shielded = test::test_controller(options);
  const auto run_once = [&] {
    run_loop({camera, perception, robot, shielded}, clock, [](double) { return false; });
  };
  EXPECT_THROW(run_once(), InputError);
  EXPECT_TRUE(robot.told.empty());
  robot.sonars = true;
  EXPECT_NO_THROW(run_once());
}

TEST(Mailbox, GivesWhatIsReadyInOrderAndLosesTheOldest) {
  Mailbox<int> mailbox(3);
  const auto any = [](int) { return true; };
  EXPECT_FALSE(mailbox.take(any));
  for (int k = 0; k < 5; ++k) mailbox.put(k);
  EXPECT_FALSE(mailbox.take([](int item) { return item > 2; })) << "the oldest is not ready";
  EXPECT_EQ(mailbox.take(any), 2);
  mailbox.put(5);
  EXPECT_EQ(mailbox.take(any), 3);
  EXPECT_EQ(mailbox.take(any), 4);
  EXPECT_EQ(mailbox.take(any), 5);
  EXPECT_FALSE(mailbox.take(any));
}

}  // namespace
}  // namespace ballservo
