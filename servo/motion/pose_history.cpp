#include "servo/motion/pose_history.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

PoseHistory::PoseHistory(std::size_t capacity) : ring_(std::max<std::size_t>(capacity, 2)) {}

const PoseHistory::Entry& PoseHistory::entry(std::size_t age) const {
  return ring_[(next_ + ring_.size() - 1 - age) % ring_.size()];
}

void PoseHistory::add(double time_s, const Pose2& pose) {
  if (!std::isfinite(time_s) || (count_ > 0 && time_s <= entry(0).time_s)) return;
  ring_[next_] = {time_s, pose};
  next_ = (next_ + 1) % ring_.size();
  count_ = std::min(count_ + 1, ring_.size());
}

std::optional<Pose2> PoseHistory::at(double time_s) const {
  for (std::size_t age = 0; age < count_; ++age) {
    const Entry& before = entry(age);
    if (!(before.time_s <= time_s)) continue;
    if (before.time_s == time_s) return before.pose;
    if (age == 0) return std::nullopt;
    const Entry& after = entry(age - 1);
    const double share = (time_s - before.time_s) / (after.time_s - before.time_s);
    const auto mix = [share](double a, double b) { return a + share * (b - a); };
    return Pose2{mix(before.pose.x_m, after.pose.x_m), mix(before.pose.y_m, after.pose.y_m),
                 before.pose.yaw_rad + share * wrap_angle(after.pose.yaw_rad - before.pose.yaw_rad)};
  }
  return std::nullopt;
}

}  // namespace ballservo
