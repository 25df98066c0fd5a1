// Where the robot will be when a command given now takes effect: through the commands still in flight.
#pragma once

#include <cstddef>
#include <vector>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// The robot at one instant.
struct RobotMotion {
  Pose2 pose;
  Twist2 twist;
};

/// Remembers the commands given and moves the robot's model (limits of speed and acceleration, exact arcs)
/// through those that have not taken effect yet. Allocates in the constructor only.
class MotionPredictor {
 public:
  /// A command given at t drives the robot from t + actuation_delay_s on, until the next one does.
  MotionPredictor(const UnicycleLimits& limits, double actuation_delay_s, std::size_t capacity);

  /// Notes a command given at time_s; times must not run backwards (such a command is ignored).
  void add_command(double time_s, const Twist2& command);

  /// The robot at now_s + actuation_delay_s, when a command given at now_s takes effect.
  RobotMotion predict(double now_s, const RobotMotion& now) const;

 private:
  struct Entry {
    double time_s = 0;
    Twist2 command;
  };
  const Entry& entry(std::size_t age) const;  // 0: the newest
  UnicycleLimits limits_;
  double delay_s_;
  std::vector<Entry> ring_;
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace ballservo
