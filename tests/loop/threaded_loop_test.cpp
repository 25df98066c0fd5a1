// The loop with threads, around ports of the tests' own: what the guard promises, and how runs end.
#include "app/loop/threaded_loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <system_error>

#include "app/loop/guarded_robot.hpp"
#include "calibration/base/fault.hpp"
#include "tests/loop/test_ports.hpp"

namespace ballservo {
namespace {

using namespace std::chrono_literals;

struct ThreadedLoop : testing::Test {
  LoopPorts ports() { return {camera, perception, robot, controller}; }

  test::TestCamera camera;
  test::TestPerception perception;
  test::TestRobot robot;
  Controller controller = test::test_controller(for_threads({}));
  WallClock clock;
};

TEST_F(ThreadedLoop, DrivesAndRestsAtItsEnd) {
  run_threaded_loop(ports(), clock, [](double time_s) { return time_s < 0.8; });
  EXPECT_TRUE(robot.drove());
  EXPECT_TRUE(robot.rests());
}

TEST_F(ThreadedLoop, FramesThatEndLeaveTheRobotAtRest) {
  camera.lives_until_s = 0.6;
  run_threaded_loop(ports(), clock, [](double time_s) { return time_s < 1.2; });
  EXPECT_TRUE(robot.drove());
  for (std::size_t k = 0; k < robot.told.size(); ++k) {
    // Stale after 0.2 s, within a period of control; what the machine slept is allowed for.
    if (robot.told_s[k] > 0.6 + 0.2 + 0.02 + 0.1) {
      EXPECT_EQ(robot.told[k].v_mps, 0.0) << robot.told_s[k];
    }
  }
}

TEST_F(ThreadedLoop, AControllerThatHangsIsStoppedByTheGuard) {
  double hung_s = 0, back_s = 0;
  run_threaded_loop(ports(), clock, [&](double time_s) {
    if (time_s < 0.8) return true;
    hung_s = clock.now_s();
    std::this_thread::sleep_for(300ms);
    back_s = clock.now_s();
    return false;
  });
  EXPECT_TRUE(robot.drove());
  int told_meanwhile = 0;
  for (std::size_t k = 0; k < robot.told.size(); ++k) {
    if (robot.told_s[k] < hung_s || robot.told_s[k] > back_s) continue;
    ++told_meanwhile;
    EXPECT_EQ(robot.told[k].v_mps, 0.0);
  }
  EXPECT_EQ(told_meanwhile, 1) << "to rest, and nothing else";
}

TEST_F(ThreadedLoop, AFaultOfTheCameraEndsTheRunAndIsHandedOn) {
  camera.lives_until_s = 0.2;
  camera.throws = true;
  EXPECT_THROW(run_threaded_loop(ports(), clock, [](double) { return true; }), std::runtime_error);
  EXPECT_TRUE(robot.rests());
}

TEST_F(ThreadedLoop, AFaultOfTheRobotEndsTheRunAndIsHandedOn) {
  robot.throws = true;
  EXPECT_THROW(run_threaded_loop(ports(), clock, [](double) { return true; }), std::runtime_error);
  EXPECT_TRUE(robot.rests()) << "it is told to rest nevertheless";
}

TEST_F(ThreadedLoop, AThreadThatCannotBeStartedEndsTheOthersAndIsSaidInWords) {
  for (const int failing : {1, 2}) {
    int asked = 0;
    std::atomic<int> running{0};
    ThreadOptions options;
    options.start = [&](std::function<void()> work) {
      if (++asked == failing)
        throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
      ++running;
      return std::thread([&running, work = std::move(work)] {
        work();
        --running;
      });
    };
    try {
      run_threaded_loop(
          ports(), clock, [](double) { return true; }, options);
      FAIL() << "ran without thread " << failing;
    } catch (const Refusal& refusal) {
      EXPECT_THAT(refusal.what(), testing::HasSubstr("could be started"));
    }
    EXPECT_EQ(asked, failing);
    EXPECT_EQ(running, 0) << "threads that outlive the run";
  }
}

TEST_F(ThreadedLoop, AShieldThatDoesNotKnowOfThreadsIsRefused) {
  robot.sonars = true;
  ControllerOptions options;
  options.avoidance.type = AvoidanceOptions::Type::shield;
  Controller shielded = test::test_controller(options);
  const GoOn once = [](double) { return false; };
  EXPECT_THROW(run_threaded_loop({camera, perception, robot, shielded}, clock, once), InputError);
  Controller knows = test::test_controller(for_threads(options));
  EXPECT_NO_THROW(run_threaded_loop({camera, perception, robot, knows}, clock, once));
}

TEST_F(ThreadedLoop, NoCommandPassesTheGuardWhereSensorsAreSilent) {
  struct Rests final : LoopObserver {
    void guard_rested(double) override { ++count; }
    int count = 0;
  } rests;
  LoopPorts watched = ports();
  watched.observers = {&rests};
  GuardOptions options;
  options.sonars = false;
  GuardedRobot guarded(watched, clock, options);
  guarded.command({0.3, 0.1}, clock.now_s());
  EXPECT_TRUE(robot.rests());
  EXPECT_EQ(rests.count, 1);

  // A step, and a frame that it heard of: now the controller is alive.
  const auto step = [this] {
    const double now_s = clock.now_s();
    controller.see(perception.look({0, now_s}).ball, now_s);
    controller.step(now_s, {}, {});
    return now_s;
  };
  guarded.read(clock.now_s());
  const double now_s = step();
  guarded.command({0.3, 0.1}, clock.now_s());
  EXPECT_EQ(robot.told.back().v_mps, 0.3);
  EXPECT_EQ(rests.count, 1);

  clock.sleep_until(now_s + options.stale_step_s + 0.01);
  guarded.guard_now();
  EXPECT_TRUE(robot.rests());
  EXPECT_EQ(rests.count, 2);

  step();
  guarded.command({0.3, 0.1}, clock.now_s());
  EXPECT_TRUE(robot.rests()) << "the command was made for a robot that the guard had not yet stopped";
  guarded.read(clock.now_s());
  step();
  guarded.command({0.3, 0.1}, clock.now_s());
  EXPECT_EQ(robot.told.back().v_mps, 0.3);
}

}  // namespace
}  // namespace ballservo
