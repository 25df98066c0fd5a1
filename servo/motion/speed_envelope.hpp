// Speeds from which the robot can still stop where it should.
#pragma once

#include <Eigen/Core>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// Share of the drive's deceleration that the envelope counts on. The rest is for a drive that brakes less
/// than its model says.
inline constexpr double envelope_braking_share = 0.85;

/// The envelope takes errors as larger by these. Its slope at an error of 0 is then sqrt(share a / (2
/// slack)), not infinite: 8 per second for the Pioneer's drive, four times the default gain of the laws.
inline constexpr double range_slack_m = 0.002, bearing_slack_rad = 0.01;

/// The largest speed from which a drive of acceleration `a` stops within `way`: sqrt(2 share a way); 0 for
/// way <= 0.
double braking_speed(double way, double acceleration, double braking_share);

/// Limits a command so that the robot, braking, does not pass its goal: the closing speed stays within
/// sqrt(2 share a (|range error| + slack)) towards the goal and within sqrt(2 share a slack) away from it,
/// the turning rate likewise with the bearing. Both are meant relative to the ball.
///   command          as the law asks for
///   range_error_m    distance to the ball in the floor plane less the desired one, when the command acts
///   p_RB, v_RB       the ball in the robot frame then (m), and its velocity over ground in those axes (m/s)
/// The path keeps its curvature: the command is scaled down as a whole, except where a ball that comes closer
/// asks for a speed of the other sign.
Twist2 limit_to_envelope(const Twist2& command, double range_error_m, const Eigen::Vector2d& p_RB,
                         const Eigen::Vector2d& v_RB, const UnicycleLimits& limits);

}  // namespace ballservo
