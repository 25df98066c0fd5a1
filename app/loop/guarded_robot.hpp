// A robot whose commands pass the guard, when they are given and for as long as it follows them.
#pragma once

#include <mutex>
#include <optional>

#include "app/loop/loop.hpp"
#include "servo/avoidance/sonar.hpp"

namespace ballservo {

/// `guard_now` may be called from any thread; the rest is called by the control thread, like the controller.
class GuardedRobot final : public Robot {
 public:
  /// `ports` and `clock` must outlive it.
  GuardedRobot(const LoopPorts& ports, const Clock& clock, const GuardOptions& options)
      : ports_(ports), clock_(clock), options_(options) {}

  /// Also tells the controller where the guard has told the robot to rest meanwhile.
  RobotState read(double now_s) override;
  /// Rests instead where the guard does not let it pass, by what is alive according to the controller.
  void command(const Twist2& twist, double now_s) override;
  void pan(double speed_radps, double now_s) override;
  bool has_sonars() const override { return ports_.robot.has_sonars(); }
  void listen(const std::function<void(const SonarReading&)>& hear) override;

  /// The guard looks: where the robot follows a command that would not pass now, it is told to rest.
  void guard_now();

 private:
  bool passes(const Twist2& twist, double now_s) const;
  void rest(double now_s);

  const LoopPorts& ports_;
  const Clock& clock_;
  GuardOptions options_;
  std::mutex mutex_;  // of all below, and the robot
  SensorStamps stamps_;
  Twist2 followed_;
  std::optional<double> rested_s_;  // since the last `read`, first by the guard
};

}  // namespace ballservo
