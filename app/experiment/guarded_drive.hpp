// The robot of a run on the wall clock: whoever looks at it moves it on to now; commands reach its drive only
// past the guard. Any thread may call anything.
#pragma once

#include <mutex>
#include <optional>
#include <vector>

#include "app/experiment/run_clock.hpp"
#include "app/experiment/run_robot.hpp"
#include "servo/avoidance/sonar_watch.hpp"

namespace ballservo {

/// What the drive was told.
struct DriveCommand {
  double time_s = 0;
  Twist2 command;
  bool by_guard = false;
};

class GuardedDrive {
 public:
  /// All three must outlive it.
  GuardedDrive(RunRobot& robot, const RunClock& clock, const GuardOptions& options)
      : robot_(robot), clock_(clock), options_(options) {}

  /// The robot now.
  RobotView look();

  /// Sonar answers that have arrived, in their order.
  std::vector<SonarReading> listen();

  /// A command of the controller, with what was alive when it was made; the guard may turn it into rest.
  void command(const Twist2& command, const SensorStamps& stamps);

  /// The guard looks: where the drive follows a command that it would not let pass now, it is told to rest.
  void guard_now();

  /// Whether the drive has been told to rest by the guard since the last time that this was asked, and when
  /// first.
  std::optional<double> rested_since_asked();

  /// All that the drive was told; whoever reads it must be the last.
  const std::vector<DriveCommand>& commands() const { return commands_; }

 private:
  void tell(double now_s, const Twist2& command, bool by_guard);
  double move_on();

  RunRobot& robot_;
  const RunClock& clock_;
  GuardOptions options_;
  std::mutex mutex_;
  SensorStamps stamps_;
  Twist2 followed_;
  std::optional<double> rested_s_;
  std::vector<DriveCommand> commands_;
};

}  // namespace ballservo
