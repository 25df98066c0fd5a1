#include "servo/motion/speed_envelope.hpp"

#include <algorithm>
#include <cmath>

#include "servo/motion/option_check.hpp"

namespace ballservo {

void EnvelopeOptions::check(FaultList& faults, const std::string& place) const {
  if (!(braking_share > 0.0 && braking_share <= 1.0)) {
    faults.add(place + ".braking_share", shown_number(braking_share), "a number above 0 and up to 1");
  }
  check_positive(faults, place + ".range_slack_m", range_slack_m, "m");
  check_positive(faults, place + ".bearing_slack_rad", bearing_slack_rad, "rad");
}

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
                         const Eigen::Vector2d& v_RB, const UnicycleLimits& limits,
                         const EnvelopeOptions& options) {
  const auto speed = [&options](double way, double acceleration) {
    return braking_speed(way, acceleration, options.braking_share);
  };
  Twist2 result = command;

  const double slack_m = options.range_slack_m;
  const double forward = speed(std::max(range_error_m, 0.0) + slack_m, limits.a_max_mps2);
  const double backward = speed(std::max(-range_error_m, 0.0) + slack_m, limits.a_max_mps2);
  cut(result, &Twist2::v_mps, v_RB.x() - backward, v_RB.x() + forward);

  const double bearing_rad = std::atan2(p_RB.y(), p_RB.x());
  const double range2 = std::max(p_RB.squaredNorm(), 1e-6);
  const double drift =
      (p_RB.x() * v_RB.y() - p_RB.y() * v_RB.x()) / range2;  // of the bearing, by the ball's motion
  const double slack_rad = options.bearing_slack_rad;
  const double left = speed(std::max(bearing_rad, 0.0) + slack_rad, limits.alpha_max_radps2);
  const double right = speed(std::max(-bearing_rad, 0.0) + slack_rad, limits.alpha_max_radps2);
  cut(result, &Twist2::w_radps, drift - right, drift + left);
  return result;
}

}  // namespace ballservo
