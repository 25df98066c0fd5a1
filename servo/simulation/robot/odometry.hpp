// What the robot believes of its own way: dead reckoning with an error that stays within a stated bound.
#pragma once

#include <cstdint>

#include "calibration/base/random.hpp"
#include "servo/motion/odometry_bound.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

struct OdometryOptions {
  OdometryBound bound;  ///< what the robot is told
  /// The errors are this many times those that the bound allows; above 1 it is broken. 0: exact odometry.
  double excess = 1;
};
void declare(OptionVisitor& v, OdometryOptions& odometry);

/// Errors are drawn anew for every run: seven tenths of the bound are the run's own (a wheel's diameter, the
/// axle's length), three tenths change with every step.
class Odometry {
 public:
  Odometry(const OdometryOptions& options, const Pose2& start, std::uint64_t seed);

  /// The robot has moved on, along one arc, to its true pose.
  void move(const Pose2& true_pose);

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
