// Where the robot was when a delayed picture was taken, and where it will be when a command given now takes
// effect.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// The last so many values with their times. Allocates in the constructor only.
template <typename Value>
class History {
 public:
  struct Entry {
    double time_s = 0;
    Value value;
  };
  explicit History(std::size_t capacity) : ring_(std::max<std::size_t>(capacity, 2)) {}

  std::size_t size() const { return count_; }
  /// 0: the newest.
  const Entry& operator[](std::size_t age) const {
    return ring_[(next_ + ring_.size() - 1 - age) % ring_.size()];
  }
  /// What is older than the newest is ignored.
  void add(double time_s, const Value& value) {
    if (!std::isfinite(time_s) || (count_ > 0 && time_s < (*this)[0].time_s)) return;
    ring_[next_] = {time_s, value};
    next_ = (next_ + 1) % ring_.size();
    count_ = std::min(count_ + 1, ring_.size());
  }

 private:
  std::vector<Entry> ring_;
  std::size_t next_ = 0, count_ = 0;
};

/// The odometry's last poses, their times rising.
using PoseHistory = History<Pose2>;

/// The pose at a time between the oldest and the newest kept, along an arc in between; nothing outside.
std::optional<Pose2> pose_at(const PoseHistory& poses, double time_s);

/// Remembers the commands given and moves the robot's model (limits of speed and acceleration, exact arcs)
/// through those that have not taken effect yet.
class MotionPredictor {
 public:
  /// A command given at t drives the robot from t + actuation_delay_s on, until the next one does.
  MotionPredictor(const UnicycleLimits& limits, double actuation_delay_s, std::size_t capacity)
      : limits_(limits), delay_s_(actuation_delay_s), commands_(capacity) {}

  /// Notes a command given at time_s; times must not run backwards (such a command is ignored).
  void add_command(double time_s, const Twist2& command) { commands_.add(time_s, command); }

  /// The robot at now_s + actuation_delay_s, when a command given at now_s takes effect.
  RobotMotion predict(double now_s, const RobotMotion& now) const {
    return follow(now, now_s, now_s + delay_s_);
  }

  /// How the wheels turn now: as the commands have made them since the last call, which is better known than
  /// what odometry measures, but no further from that than its bound. Times must rise.
  Twist2 twist_at(double now_s, const Twist2& measured, const OdometryBound& bound);

 private:
  RobotMotion follow(RobotMotion robot, double from_s, double until_s) const;

  UnicycleLimits limits_;
  double delay_s_;
  History<Twist2> commands_;
  std::optional<History<Twist2>::Entry> last_twist_;
};

}  // namespace ballservo
