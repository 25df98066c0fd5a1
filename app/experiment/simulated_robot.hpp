// A scenario's robot: its drive, what its odometry makes of the way, and its sonars.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "app/experiment/run_record.hpp"
#include "app/loop/ports.hpp"
#include "app/scenario/scenario.hpp"
#include "servo/simulation/robot/unicycle_robot.hpp"

namespace ballservo {

/// The robot as it truly is at one instant.
struct RobotTruth {
  double time_s = 0;
  Pose2 pose;
  Twist2 twist;
  PanMotion pan{};
};

/// A robot of which a record is made: beside what it says, the truth as far as somebody tells it.
class WatchedRobot : public Robot {
 public:
  /// What was true at the last `read`; for its thread.
  virtual std::optional<RobotTruth> when_read() const = 0;
  /// All that the sonars have said; not while other threads may look at the robot.
  virtual const std::vector<SonarFiring>& firings() const = 0;
};

/// A camera's pan with its stops: a drive that turns on the spot.
class SimulatedPan {
 public:
  SimulatedPan(const PanLimits& limits, double actuation_delay_s)
      : max_rad_(limits.max_rad), drive_({}, drive_limits(limits), actuation_delay_s) {}
  void command(double speed_radps) { drive_.command({0, speed_radps}); }
  PanMotion advance_to(double time_s);

 private:
  double max_rad_;
  UnicycleRobot drive_;
};

/// Whoever looks at it moves it on to then, its sonars fire on the way. Loop and camera may do so from two
/// threads.
class SimulatedRobot final : public WatchedRobot {
 public:
  /// `world` must outlive the robot. Without `body` it is a UnicycleRobot.
  SimulatedRobot(const World& world, const RobotSettings& settings, std::uint64_t seed,
                 std::shared_ptr<RobotBody> body = nullptr, const PanLimits& pan = {});

  RobotState read(double now_s) override;
  void command(const Twist2& twist, double now_s) override;
  void pan(double speed_radps, double now_s) override;
  bool has_sonars() const override { return sonar_.has_value(); }
  void listen(const std::function<void(const SonarReading&)>& hear) override;

  /// Somebody puts it there, now.
  void put(const Pose2& pose);
  /// The world's obstacles stand elsewhere from now on.
  void look_around();

  /// The truth then, or at the latest time that anybody has looked.
  RobotTruth at(double now_s);
  std::optional<RobotTruth> when_read() const override { return when_read_; }
  /// The truth when anybody last looked; not while other threads may look at the robot.
  const RobotTruth& now() const { return now_; }
  const std::vector<SonarFiring>& firings() const override { return firings_; }
  /// All firings but the newest ones: so many, or up to twice as many.
  void forget(std::size_t most) { forget_before_last(most, firings_); }

 private:
  void move_on(double now_s);

  std::mutex mutex_;
  std::shared_ptr<RobotBody> body_;
  std::optional<SimulatedPan> pan_;
  RobotTruth now_;
  Odometry odometry_;
  std::optional<SonarRing> sonar_;
  RobotTruth when_read_;
  std::vector<SonarFiring> firings_;
};

}  // namespace ballservo
