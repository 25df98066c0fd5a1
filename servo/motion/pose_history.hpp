// Where the robot was when a delayed picture was taken.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// The odometry's last poses with their times; allocates in the constructor only.
class PoseHistory {
 public:
  explicit PoseHistory(std::size_t capacity);

  /// A pose not later than the newest is ignored.
  void add(double time_s, const Pose2& pose);
  /// The pose at a time between the oldest and the newest kept, linear in between; nothing outside.
  std::optional<Pose2> at(double time_s) const;

 private:
  struct Entry {
    double time_s = 0;
    Pose2 pose;
  };
  const Entry& entry(std::size_t age) const;  // 0: the newest
  std::vector<Entry> ring_;
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace ballservo
