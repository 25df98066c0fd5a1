#include "servo/motion/unicycle.hpp"

#include <limits>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

/// sin(x)/x and (1 - cos(x))/x, also where x is tiny.
double sinc(double x) { return std::abs(x) < 1e-4 ? 1.0 - x * x / 6.0 : std::sin(x) / x; }
double cosc(double x) {
  return std::abs(x) < 1e-4 ? 0.5 * x * (1.0 - x * x / 12.0) : (1.0 - std::cos(x)) / x;
}

/// The scales k with k * value within [low, high], cut with [k_low, k_high]; empty when k_low > k_high.
void cut_scales(double value, double low, double high, double& k_low, double& k_high) {
  if (value == 0.0) {
    if (low > 0.0 || high < 0.0) k_high = -1.0;
    return;
  }
  const double a = low / value, b = high / value;
  k_low = std::max(k_low, std::min(a, b));
  k_high = std::min(k_high, std::max(a, b));
}

/// Scales the whole command so that `speed` (one of its two parts) lies in [low, high].
void cut(Twist2& command, double Twist2::*speed, double low, double high) {
  const double wanted = command.*speed;
  const double allowed = std::clamp(wanted, low, high);
  if (allowed == wanted) return;
  const double scale = allowed / wanted;
  if (scale >= 0.0) {
    command.v_mps *= scale;
    command.w_radps *= scale;
  }
  command.*speed = allowed;
}

}  // namespace

void declare(OptionVisitor& v, UnicycleLimits& limits) {
  v.number("v_max_mps", limits.v_max_mps, NumberRange::above(0, 10, "m/s"), "largest speed, either way");
  v.number("w_max_radps", limits.w_max_radps, NumberRange::above(0, 20, "rad/s"), "largest turning rate");
  v.number("a_max_mps2", limits.a_max_mps2, NumberRange::above(0, 20, "m/s^2"),
           "acceleration and deceleration along the way");
  v.number("alpha_max_radps2", limits.alpha_max_radps2, NumberRange::above(0, 100, "rad/s^2"),
           "acceleration and deceleration of the turn");
}

void declare(OptionVisitor& v, OdometryBound& bound) {
  const NumberRange share = NumberRange::within(0, 0.2, "");
  v.number("distance_share", bound.distance_share, share, "largest error, of the way");
  v.number("turn_share", bound.turn_share, share, "largest error, of the turned angle");
  v.number("turn_per_m_radpm", bound.turn_per_m_radpm, NumberRange::within(0, 0.2, "rad/m"),
           "largest veering along the way");
}

double wrap_angle(double angle_rad) {
  if (angle_rad > -M_PI && angle_rad <= M_PI) return angle_rad;  // std::remainder takes long
  const double wrapped = std::remainder(angle_rad, 2.0 * M_PI);
  return wrapped <= -M_PI ? M_PI : wrapped;
}

Pose2 integrate(const Pose2& pose, const Twist2& twist, double dt_s) {
  const double turn_rad = twist.w_radps * dt_s;
  const double length_m = twist.v_mps * dt_s;
  const double forward_m = length_m * sinc(turn_rad);
  const double left_m = length_m * cosc(turn_rad);
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  return {pose.x_m + c * forward_m - s * left_m, pose.y_m + s * forward_m + c * left_m,
          pose.yaw_rad + turn_rad};
}

Twist2 limit_speed(const Twist2& command, const UnicycleLimits& limits) {
  const double excess = std::max(
      {1.0, std::abs(command.v_mps) / limits.v_max_mps, std::abs(command.w_radps) / limits.w_max_radps});
  return {command.v_mps / excess, command.w_radps / excess};
}

Twist2 limit_acceleration(const Twist2& current, const Twist2& command, const UnicycleLimits& limits,
                          double dt_s) {
  const Twist2 wanted = limit_speed(command, limits);
  const double dv = limits.a_max_mps2 * dt_s, dw = limits.alpha_max_radps2 * dt_s;

  if (wanted.rests()) {
    const double share = std::max(std::abs(current.v_mps) / dv, std::abs(current.w_radps) / dw);
    if (share <= 1.0) return wanted;
    return {current.v_mps * (1.0 - 1.0 / share), current.w_radps * (1.0 - 1.0 / share)};
  }

  double k_low = 0.0, k_high = std::numeric_limits<double>::infinity();
  const auto cut_to_reach = [&](double speed, double now, double change, double most) {
    cut_scales(speed, now - change, now + change, k_low, k_high);
    // A scale above 1 must not take a speed over its limit, nor over what it is.
    const double limit = std::max(most, std::abs(now));
    cut_scales(speed, -limit, limit, k_low, k_high);
  };
  cut_to_reach(wanted.v_mps, current.v_mps, dv, limits.v_max_mps);
  cut_to_reach(wanted.w_radps, current.w_radps, dw, limits.w_max_radps);
  if (k_low <= k_high) {
    const double k = std::clamp(1.0, k_low, k_high);
    return {k * wanted.v_mps, k * wanted.w_radps};
  }
  return {std::clamp(wanted.v_mps, current.v_mps - dv, current.v_mps + dv),
          std::clamp(wanted.w_radps, current.w_radps - dw, current.w_radps + dw)};
}

RobotMotion drive(RobotMotion robot, const Twist2& command, const UnicycleLimits& limits, double dt_s,
                  int steps) {
  const double h = dt_s / steps;
  for (int i = 0; i < steps; ++i) {
    const Twist2 after = limit_acceleration(robot.twist, command, limits, h);
    robot.pose = integrate(robot.pose, mean_twist(robot.twist, after), h);
    robot.twist = after;
  }
  return robot;
}

double braking_speed(double way, double acceleration, double braking_share) {
  return way > 0.0 ? std::sqrt(2.0 * braking_share * acceleration * way) : 0.0;
}

Twist2 limit_to_envelope(const Twist2& command, double range_error_m, const Eigen::Vector2d& p_RB,
                         const Eigen::Vector2d& v_RB, const UnicycleLimits& limits) {
  const auto speed = [](double way, double acceleration) {
    return braking_speed(way, acceleration, envelope_braking_share);
  };
  Twist2 result = command;

  const double forward = speed(std::max(range_error_m, 0.0) + range_slack_m, limits.a_max_mps2);
  const double backward = speed(std::max(-range_error_m, 0.0) + range_slack_m, limits.a_max_mps2);
  cut(result, &Twist2::v_mps, v_RB.x() - backward, v_RB.x() + forward);

  const double bearing_rad = std::atan2(p_RB.y(), p_RB.x());
  const double range2 = std::max(p_RB.squaredNorm(), 1e-6);
  const double drift = cross(p_RB, v_RB) / range2;  // of the bearing, by the ball's motion
  const double left = speed(std::max(bearing_rad, 0.0) + bearing_slack_rad, limits.alpha_max_radps2);
  const double right = speed(std::max(-bearing_rad, 0.0) + bearing_slack_rad, limits.alpha_max_radps2);
  cut(result, &Twist2::w_radps, drift - right, drift + left);
  return result;
}

Eigen::Isometry3d X_WR(const Pose2& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(pose.x_m, pose.y_m, 0.0);
  X.linear() = Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return X;
}

Eigen::Vector2d in_robot_frame(const Pose2& pose, const Eigen::Vector2d& p_W) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const double x = p_W.x() - pose.x_m, y = p_W.y() - pose.y_m;
  return {c * x + s * y, -s * x + c * y};
}

Eigen::Vector2d in_world_frame(const Pose2& pose, const Eigen::Vector2d& p_R) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  return {pose.x_m + c * p_R.x() - s * p_R.y(), pose.y_m + s * p_R.x() + c * p_R.y()};
}

}  // namespace ballservo
