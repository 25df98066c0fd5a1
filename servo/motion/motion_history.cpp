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
    const double x_m = after.x_m - before.x_m, y_m = after.y_m - before.y_m;
    const double turn_rad = wrap_angle(after.yaw_rad - before.yaw_rad);
    const double aside = 0.5 * share * (1.0 - share) * turn_rad;  // the arc's way off its chord, over it
    return Pose2{before.x_m + share * x_m + aside * y_m, before.y_m + share * y_m - aside * x_m,
                 before.yaw_rad + share * turn_rad};
  }
  return std::nullopt;
}

RobotMotion MotionPredictor::follow(RobotMotion robot, double from_s, double until_s) const {
  constexpr double most_steps = 1e5;  // by then every drive has settled, whatever a clock says
  const auto hold = [&](const Twist2& command, double dt_s) {
    const double steps = std::clamp(std::ceil(dt_s / drive_step_s), 1.0, most_steps);
    robot = drive(robot, command, limits_, dt_s, static_cast<int>(steps));
  };
  // From the oldest command to the newest: each drives until the next takes effect.
  for (std::size_t age = commands_.size(); age-- > 0;) {
    const double next_s = age == 0 ? until_s : std::min(until_s, commands_[age - 1].time_s + delay_s_);
    const double first_s = std::max(from_s, commands_[age].time_s + delay_s_);
    if (!(next_s > first_s)) continue;
    if (first_s > from_s) hold({}, first_s - from_s);  // before the first command: at rest
    hold(commands_[age].value, next_s - first_s);
    from_s = next_s;
  }
  return robot;
}

Twist2 MotionPredictor::twist_at(double now_s, const Twist2& measured, const OdometryBound& bound) {
  const Twist2 expected =
      last_twist_ ? follow({{}, last_twist_->value}, last_twist_->time_s, now_s).twist : measured;
  last_twist_ = {now_s, bound.nearest_true(measured, expected)};
  return last_twist_->value;
}

}  // namespace ballservo
