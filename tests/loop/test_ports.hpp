// A camera, a perception and a robot for tests of the loop.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "app/loop/loop.hpp"
#include "servo/features/builtin_laws.hpp"

namespace ballservo::test {

/// Gives a frame a hundredth of a second, up to some time; then nothing, or a fault.
class TestCamera final : public FrameSource {
 public:
  std::optional<CameraFrame> take(Clock& clock, double until_s) override {
    const double due_s = static_cast<double>(frames_ + 1) / 100;
    if (due_s > until_s) return std::nullopt;
    clock.sleep_until(due_s);
    if (due_s > lives_until_s && throws) throw std::runtime_error("unplugged");
    if (due_s > lives_until_s) return std::nullopt;
    CameraFrame frame{frames_++, due_s, due_s + latency_s};
    frame.pan_rad = pan_rad;
    return frame;
  }
  double lives_until_s = 1e9, latency_s = 0, pan_rad = 0;
  bool throws = false;

 private:
  long frames_ = 0;
};

/// Always sees the ball, a metre and a half ahead.
class TestPerception final : public BallPerception {
 public:
  Percept look(const CameraFrame& frame) override {
    const ServoGoal goal;
    Percept percept;
    percept.ball = {frame.time_s, TrackState::confirmed,
                    goal.mount.X_RC().inverse() * Eigen::Vector3d(1.5, 0.0, goal.ball_height_m),
                    1e-6 * Eigen::Matrix3d::Identity()};
    percept.floor.count = 2;
    percept.floor.rays[1].bearing_rad = 0.1;
    if (works) works();
    return percept;
  }
  std::function<void()> works;
};

/// Remembers what it was told, and is where it was.
class TestRobot final : public Robot {
 public:
  TestRobot() {
    told.reserve(10000);
    told_s.reserve(10000);
    panned.reserve(10000);
  }
  RobotState read(double now_s) override { return {now_s, {}, {}}; }
  void command(const Twist2& twist, double now_s) override {
    told.push_back(twist);
    told_s.push_back(now_s);
    if (throws && twist.v_mps > 0) throw std::runtime_error("motor off");
  }
  void pan(double speed_radps, double) override { panned.push_back(speed_radps); }
  bool has_sonars() const override { return sonars; }

  bool rests() const { return told.back().v_mps == 0.0 && told.back().w_radps == 0.0; }
  bool drove() const {
    return std::any_of(told.begin(), told.end(), [](const Twist2& twist) { return twist.v_mps > 0.05; });
  }
  std::vector<Twist2> told;
  std::vector<double> told_s, panned;
  bool throws = false, sonars = false;
};

inline Controller test_controller(const ControllerOptions& options = {}) {
  return Controller(options, builtin_laws().make({}, options.goal));
}

}  // namespace ballservo::test
