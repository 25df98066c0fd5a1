#include "servo/motion/speed_envelope.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

double braking_speed(double way, double acceleration, double braking_share) {
  return way > 0.0 ? std::sqrt(2.0 * braking_share * acceleration * way) : 0.0;
}

namespace {

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
  const double drift =
      (p_RB.x() * v_RB.y() - p_RB.y() * v_RB.x()) / range2;  // of the bearing, by the ball's motion
  const double left = speed(std::max(bearing_rad, 0.0) + bearing_slack_rad, limits.alpha_max_radps2);
  const double right = speed(std::max(-bearing_rad, 0.0) + bearing_slack_rad, limits.alpha_max_radps2);
  cut(result, &Twist2::w_radps, drift - right, drift + left);
  return result;
}

}  // namespace ballservo
