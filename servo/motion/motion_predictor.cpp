#include "servo/motion/motion_predictor.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

/// One command held for dt_s; the twist changes over it, so short steps with the mean twist.
void drive(RobotMotion& robot, const Twist2& command, double dt_s, const UnicycleLimits& limits) {
  constexpr double max_step_s = 0.002;
  const int steps = std::max(1, static_cast<int>(std::ceil(dt_s / max_step_s)));
  for (int i = 0; i < steps; ++i) {
    const double h = dt_s / steps;
    const Twist2 after = limit_acceleration(robot.twist, command, limits, h);
    const Twist2 mean{0.5 * (robot.twist.v_mps + after.v_mps), 0.5 * (robot.twist.w_radps + after.w_radps)};
    robot.pose = integrate(robot.pose, mean, h);
    robot.twist = after;
  }
}

}  // namespace

MotionPredictor::MotionPredictor(const UnicycleLimits& limits, double actuation_delay_s, std::size_t capacity)
    : limits_(limits), delay_s_(actuation_delay_s), ring_(std::max<std::size_t>(capacity, 2)) {}

const MotionPredictor::Entry& MotionPredictor::entry(std::size_t age) const {
  return ring_[(next_ + ring_.size() - 1 - age) % ring_.size()];
}

void MotionPredictor::add_command(double time_s, const Twist2& command) {
  if (!std::isfinite(time_s) || (count_ > 0 && time_s < entry(0).time_s)) return;
  ring_[next_] = {time_s, command};
  next_ = (next_ + 1) % ring_.size();
  count_ = std::min(count_ + 1, ring_.size());
}

RobotMotion MotionPredictor::predict(double now_s, const RobotMotion& now) const {
  RobotMotion robot = now;
  const double end_s = now_s + delay_s_;
  double at_s = now_s;
  // From the oldest command to the newest: each drives until the next takes effect.
  for (std::size_t age = count_; age-- > 0;) {
    const double until_s = age == 0 ? end_s : std::min(end_s, entry(age - 1).time_s + delay_s_);
    const double from_s = std::max(at_s, entry(age).time_s + delay_s_);
    if (until_s <= from_s) continue;
    if (from_s > at_s) drive(robot, {}, from_s - at_s, limits_);  // before the first command: at rest
    drive(robot, entry(age).command, until_s - from_s, limits_);
    at_s = until_s;
  }
  return robot;
}

}  // namespace ballservo
