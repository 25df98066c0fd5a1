// The simulated robot: takes commands, answers them late, within its limits, along exact arcs; and what it
// believes of its own way.
#pragma once

#include <cstdint>
#include <deque>

#include "calibration/base/random.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

/// What is driven: where it truly is, and how it answers commands. Called by one thread at a time.
class RobotBody {
 public:
  virtual ~RobotBody() = default;
  /// A command given now.
  virtual void command(const Twist2& twist) = 0;
  /// Moves on to a time not before now; where it is then, and how it moves.
  virtual RobotMotion advance_to(double time_s) = 0;
  /// Somebody puts it there.
  virtual void put(const Pose2& pose) = 0;
};

class UnicycleRobot : public RobotBody {
 public:
  /// `actuation_delay_s`: from a command's arrival to the first moment at which the drive follows it. Throws
  /// InputError for limits that are not positive or a delay that is negative or not finite.
  UnicycleRobot(const Pose2& start, const UnicycleLimits& limits, double actuation_delay_s);

  /// Until the next one takes effect the drive goes on towards this one. A command with a speed that is not
  /// finite counts as one to stand still.
  void command(const Twist2& twist) override;

  /// Speeds change in steps of at most 1 ms; within each the path is an exact arc.
  RobotMotion advance_to(double time_s) override;

  /// Its wheels turn as before.
  void put(const Pose2& pose) override { motion_.pose = pose; }
  /// Something holds it there, for now.
  void hold(const Pose2& pose) { motion_ = {pose, {}}; }

  double time_s() const { return time_s_; }
  const Pose2& pose() const { return motion_.pose; }     ///< X_WR; the yaw is not wrapped
  const Twist2& twist() const { return motion_.twist; }  ///< as the wheels turn now

 private:
  struct Pending {
    double time_s;
    Twist2 twist;
  };
  void drive(double until_s);

  RobotMotion motion_;
  UnicycleLimits limits_;
  double delay_s_;
  double time_s_ = 0;
  Twist2 followed_;
  std::deque<Pending> pending_;
};

struct OdometryOptions {
  OdometryBound bound;  ///< what the robot is told
  /// The errors are this many times those that the bound allows; above 1 it is broken. 0: exact odometry.
  double excess = 1;
};
void declare(OptionVisitor& v, OdometryOptions& odometry);

/// Dead reckoning with an error that stays within a stated bound. Errors are drawn anew for every run: seven
/// tenths of the bound are the run's own (a wheel's diameter, the axle's length), three tenths change with
/// every step.
class Odometry {
 public:
  Odometry(const OdometryOptions& options, const Pose2& start, std::uint64_t seed);

  /// The robot has moved on, along one arc, to its true pose.
  void move(const Pose2& true_pose);
  /// Somebody has put it there: wheels that did not turn say nothing of it. An exact odometry knows.
  void put(const Pose2& true_pose) { true_pose_ = true_pose; }

  const Pose2& pose() const { return pose_; }
  /// The wheels' speeds as measured when they truly are `twist`.
  Twist2 measure(const Twist2& twist) const;

 private:
  OdometryOptions options_;
  bool exact_ = false;
  RandomEngine engine_;
  double scale_error_, turn_error_, veer_error_;  // the run's own, in shares of the bound
  Pose2 pose_, true_pose_;
};

}  // namespace ballservo
