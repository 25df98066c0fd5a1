// The loop with threads, around ports of the tests' own: what the guard promises, and how runs end.
#include "app/loop/threaded_loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "app/loop/guarded_robot.hpp"
#include "calibration/base/fault.hpp"
#include "servo/features/builtin_laws.hpp"

namespace ballservo {
namespace {

using namespace std::chrono_literals;

/// Gives a frame a hundredth of a second, up to some time; then nothing, or a fault.
class TestCamera final : public FrameSource {
 public:
  std::optional<CameraFrame> take(Clock& clock, double until_s) override {
    const double due_s = static_cast<double>(frames_ + 1) / 100;
    if (due_s > until_s) return std::nullopt;
    clock.sleep_until(due_s);
    if (due_s > until_s_ && throws_) throw std::runtime_error("unplugged");
    if (due_s > until_s_) return std::nullopt;
    return CameraFrame{frames_++, due_s};
  }
  double until_s_ = 1e9;
  bool throws_ = false;

 private:
  long frames_ = 0;
};

/// Always sees the ball, a metre and a half ahead.
class TestPerception final : public BallPerception {
 public:
  explicit TestPerception(const ServoGoal& goal) : goal_(goal) {}
  Percept look(const CameraFrame& frame) override {
    Percept percept;
    percept.ball = {frame.time_s, TrackState::confirmed,
                    goal_.mount.X_RC().inverse() * Eigen::Vector3d(1.5, 0.0, goal_.ball_height_m),
                    1e-6 * Eigen::Matrix3d::Identity()};
    return percept;
  }

 private:
  ServoGoal goal_;
};

/// Remembers what it was told, and is where it was.
class TestRobot final : public Robot {
 public:
  RobotState read(double now_s) override { return {now_s, {}, {}}; }
  void command(const Twist2& twist, double now_s) override {
    told.push_back(twist);
    told_s.push_back(now_s);
    if (throws && twist.v_mps > 0) throw std::runtime_error("motor off");
  }
  bool rests() const { return told.back().v_mps == 0.0 && told.back().w_radps == 0.0; }
  bool drove() const {
    return std::any_of(told.begin(), told.end(), [](const Twist2& twist) { return twist.v_mps > 0.05; });
  }
  std::vector<Twist2> told;
  std::vector<double> told_s;
  bool throws = false;
};

struct ThreadedLoop : testing::Test {
  LoopPorts ports() { return {camera, perception, robot, controller}; }

  TestCamera camera;
  TestPerception perception{ServoGoal{}};
  TestRobot robot;
  Controller controller{for_threads({}), builtin_laws().make({}, {})};
  WallClock clock;
};

TEST_F(ThreadedLoop, DrivesAndRestsAtItsEnd) {
  run_threaded_loop(ports(), clock, [](double time_s) { return time_s < 0.8; });
  EXPECT_TRUE(robot.drove());
  EXPECT_TRUE(robot.rests());
}

TEST_F(ThreadedLoop, FramesThatEndLeaveTheRobotAtRest) {
  camera.until_s_ = 0.6;
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
  std::size_t told_when_back = 0;
  bool rested = false;
  run_threaded_loop(ports(), clock, [&](double time_s) {
    if (time_s < 0.8) return true;
    const std::size_t before = robot.told.size();
    std::this_thread::sleep_for(300ms);
    told_when_back = robot.told.size() - before;
    rested = robot.rests();
    return false;
  });
  EXPECT_TRUE(robot.drove());
  EXPECT_EQ(told_when_back, 1u) << "one command to rest, and no other";
  EXPECT_TRUE(rested);
}

TEST_F(ThreadedLoop, AFaultOfTheCameraEndsTheRunAndIsHandedOn) {
  camera.until_s_ = 0.2;
  camera.throws_ = true;
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
  struct WithSonars final : Robot {
    RobotState read(double now_s) override { return {now_s, {}, {}}; }
    void command(const Twist2&, double) override {}
    bool has_sonars() const override { return true; }
  } with_sonars;
  ControllerOptions options;
  options.avoidance.type = AvoidanceOptions::Type::shield;
  Controller shielded(options, builtin_laws().make({}, {}));
  const GoOn once = [](double) { return false; };
  EXPECT_THROW(run_threaded_loop({camera, perception, with_sonars, shielded}, clock, once), InputError);
  Controller counts_on_threads(for_threads(options), builtin_laws().make({}, {}));
  EXPECT_NO_THROW(run_threaded_loop({camera, perception, with_sonars, counts_on_threads}, clock, once));
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
  const double now_s = clock.now_s();
  controller.see(perception.look({0, now_s}).ball, now_s);
  controller.step(now_s, {}, {});
  guarded.command({0.3, 0.1}, clock.now_s());
  EXPECT_EQ(robot.told.back().v_mps, 0.3);
  EXPECT_EQ(rests.count, 1);

  clock.sleep_until(now_s + options.stale_step_s + 0.01);
  guarded.guard_now();
  EXPECT_TRUE(robot.rests());
  EXPECT_EQ(rests.count, 2);
}

}  // namespace
}  // namespace ballservo
