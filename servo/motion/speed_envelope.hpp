// Speeds from which the robot can still stop where it should.
#pragma once

#include <Eigen/Core>
#include <string>

#include "calibration/base/fault.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

struct EnvelopeOptions {
  /// Share of the drive's acceleration that braking is planned with; the rest covers what the plan does not
  /// know.
  double braking_share = 0.85;
  /// Errors are taken as larger by these: without them the speed could not follow the law to zero, since the
  /// envelope's slope grows without bound there.
  double range_slack_m = 0.002;
  double bearing_slack_rad = 0.01;

  /// Adds a fault for a share outside (0, 1] or a slack that is not finite and positive.
  void check(FaultList& faults, const std::string& place) const;
};

/// The largest speed from which a drive of acceleration `a` stops within `way`: sqrt(2 share a way); 0 for
/// way <= 0.
double braking_speed(double way, double acceleration, double braking_share);

/// Limits a command so that the robot, braking, does not pass its goal: the closing speed stays within
/// sqrt(2 share a (|range error| + slack)) towards the goal and within sqrt(2 share a slack) away from it,
/// the turning rate likewise with the bearing. Both are meant relative to the ball.
///   command          as the law asks for
///   range_error_m    distance to the ball in the floor plane less the desired one, when the command takes
///   effect p_RB, v_RB       the ball in the robot frame then (m), and its own velocity over ground in those
///   axes (m/s)
/// The path keeps its curvature: the command is scaled down as a whole, except where a ball that comes closer
/// asks for a speed of the other sign.
Twist2 limit_to_envelope(const Twist2& command, double range_error_m, const Eigen::Vector2d& p_RB,
                         const Eigen::Vector2d& v_RB, const UnicycleLimits& limits,
                         const EnvelopeOptions& options);

}  // namespace ballservo
