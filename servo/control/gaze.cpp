#include "servo/control/gaze.hpp"

#include <algorithm>
#include <cmath>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace {
constexpr double gain_per_s = 6.0;  // with the loop's delay predicted, a fifth of what is stable at 30 Hz
constexpr double nearest_ball_m = 0.05;  // a ball nearer to the pan's axis has no azimuth
constexpr double scan_radps = 1.4;       // as the robot turns while it searches
constexpr double at_stop_rad = 0.1;
}  // namespace

Gaze::Gaze(const CameraMount& mount, double aside_max_rad, double actuation_delay_s, std::size_t history)
    : mount_(mount),
      aside_max_rad_(aside_max_rad),
      predictor_(drive_limits(mount.pan), actuation_delay_s, history) {}

double Gaze::follow(double time_s, const PanMotion& now, const Target& target, const Twist2& twist) {
  const Eigen::Vector2d p = target.p_RB - Eigen::Vector2d(mount_.forward_m, 0);
  if (!(p.norm() > nearest_ball_m)) return look_aside(0, time_s, now);
  // In the robot's axes: the ball's own velocity less that of the floor under it.
  const Eigen::Vector2d v(target.v_RB.x() - twist.v_mps + twist.w_radps * target.p_RB.y(),
                          target.v_RB.y() - twist.w_radps * target.p_RB.x());
  const double azimuth_rad = std::atan2(p.y(), p.x());
  if (std::abs(azimuth_rad) <= aside_max_rad_) return look_aside(0, time_s, now);
  return turn_to({azimuth_rad - std::copysign(aside_max_rad_, azimuth_rad), cross(p, v) / p.squaredNorm()},
                 time_s, now);
}

double Gaze::look_aside(double side, double time_s, const PanMotion& now) {
  return turn_to({side * mount_.pan.max_rad, 0, scan_radps}, time_s, now);
}

double Gaze::scan(double time_s, const PanMotion& now) {
  if (mount_.pan.max_rad - side_ * now.angle_rad < at_stop_rad) side_ = -side_;
  return look_aside(side_, time_s, now);
}

double Gaze::turn_to(const Aim& aim, double time_s, const PanMotion& now) {
  const PanLimits& limits = mount_.pan;
  if (!limits.turns() || !std::isfinite(now.angle_rad) || !std::isfinite(now.speed_radps)) return 0;
  const double pan_rad =
      predictor_.predict(time_s, {{0, 0, now.angle_rad}, {0, now.speed_radps}}).pose.yaw_rad;
  const auto brakes_within = [&](double way_rad) {
    return braking_speed(way_rad, limits.acceleration_max_radps2, envelope_braking_share);
  };
  const double e = std::clamp(aim.angle_rad, -limits.max_rad, limits.max_rad) - pan_rad;
  const double closing = std::min(aim.closing_max_radps, brakes_within(std::abs(e) + bearing_slack_rad));
  double speed = std::clamp(gain_per_s * e, -closing, closing) + aim.speed_radps;
  speed =
      std::clamp(speed, -brakes_within(limits.max_rad + pan_rad), brakes_within(limits.max_rad - pan_rad));
  speed = std::clamp(speed, -limits.speed_max_radps, limits.speed_max_radps);
  predictor_.add_command(time_s, {0, speed});
  return speed;
}

}  // namespace ballservo
