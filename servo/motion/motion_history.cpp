#include "servo/motion/motion_history.hpp"

namespace ballservo {

std::optional<Pose2> pose_at(const PoseHistory& poses, double time_s) {
  for (std::size_t age = 0; age < poses.size(); ++age) {
    const auto& [before_s, before] = poses[age];
    if (!(before_s <= time_s)) continue;
    if (before_s == time_s) return before;
    if (age == 0) return std::nullopt;
    const auto& [after_s, after] = poses[age - 1];
    const double share = (time_s - before_s) / (after_s - before_s);
    return Pose2{before.x_m + share * (after.x_m - before.x_m), before.y_m + share * (after.y_m - before.y_m),
                 before.yaw_rad + share * wrap_angle(after.yaw_rad - before.yaw_rad)};
  }
  return std::nullopt;
}

RobotMotion MotionPredictor::predict(double now_s, const RobotMotion& now) const {
  constexpr double max_step_s = 0.002;
  RobotMotion robot = now;
  const auto hold = [&](const Twist2& command, double dt_s) {
    const int steps = std::max(1, static_cast<int>(std::ceil(dt_s / max_step_s)));
    robot = drive(robot, command, limits_, dt_s, steps);
  };
  const double end_s = now_s + delay_s_;
  double at_s = now_s;
  // From the oldest command to the newest: each drives until the next takes effect.
  for (std::size_t age = commands_.size(); age-- > 0;) {
    const double until_s = age == 0 ? end_s : std::min(end_s, commands_[age - 1].time_s + delay_s_);
    const double from_s = std::max(at_s, commands_[age].time_s + delay_s_);
    if (until_s <= from_s) continue;
    if (from_s > at_s) hold({}, from_s - at_s);  // before the first command: at rest
    hold(commands_[age].value, until_s - from_s);
    at_s = until_s;
  }
  return robot;
}

}  // namespace ballservo
