// The simulated robot: takes commands, answers them late, within its limits, along exact arcs.
#pragma once

#include <deque>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

class UnicycleRobot {
 public:
  /// `actuation_delay_s`: from a command's arrival to the first moment at which the drive follows it. Throws
  /// InputError for limits that are not positive or a delay that is negative or not finite.
  UnicycleRobot(const Pose2& start, const UnicycleLimits& limits, double actuation_delay_s);

  /// A command given now; until the next one takes effect the drive goes on towards this one. A command with
  /// a speed that is not finite counts as one to stand still.
  void command(const Twist2& twist);

  /// Moves on to a time not before now. Speeds change in steps of at most 1 ms; within each the path is an
  /// exact arc.
  void advance_to(double time_s);

  double time_s() const { return time_s_; }
  const Pose2& pose() const { return pose_; }     ///< X_WR; the yaw is not wrapped
  const Twist2& twist() const { return twist_; }  ///< as the wheels turn now

 private:
  struct Pending {
    double time_s;
    Twist2 twist;
  };
  void drive(double until_s);

  Pose2 pose_;
  UnicycleLimits limits_;
  double delay_s_;
  double time_s_ = 0;
  Twist2 twist_, followed_;
  std::deque<Pending> pending_;
};

}  // namespace ballservo
