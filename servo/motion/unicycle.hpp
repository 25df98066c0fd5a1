// A robot with two driven wheels: what it is, its plane kinematics, and the speeds that it can keep.
//
// Robot frame R: x forward, y left, z up, origin on the floor under the middle of the axle. World frame W: z
// up, floor at z = 0. Yaw counts from the world's x axis, counter-clockwise seen from above.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {

class OptionVisitor;

/// Where the robot stands: X_WR in the plane.
struct Pose2 {
  double x_m = 0, y_m = 0, yaw_rad = 0;
};

/// Between where two poses stand.
inline double distance_m(const Pose2& a, const Pose2& b) { return std::hypot(b.x_m - a.x_m, b.y_m - a.y_m); }

/// How it moves: forward speed and turning rate (counter-clockwise positive), in the robot frame.
struct Twist2 {
  double v_mps = 0, w_radps = 0;

  bool is_finite() const { return std::isfinite(v_mps) && std::isfinite(w_radps); }
  bool rests() const { return v_mps == 0.0 && w_radps == 0.0; }
};

/// What the drive can do. Defaults: Pioneer 3-DX (speeds from its data sheet; accelerations as its firmware
/// is set by default, taken here as an assumption).
struct UnicycleLimits {
  double v_max_mps = 1.2;
  double w_max_radps = 300.0 * 0.017453292519943295;
  double a_max_mps2 = 0.3;
  double alpha_max_radps2 = 100.0 * 0.017453292519943295;
};
void declare(OptionVisitor& v, UnicycleLimits& limits);

/// The rectangle that the robot covers on the floor, in its own frame.
struct Footprint {
  double front_m = 0.210, rear_m = 0.301;  ///< ahead of the axle, behind it
  double half_width_m = 0.2125;

  /// From the axle to the outermost corner.
  double reach_m() const { return std::hypot(std::max(front_m, rear_m), half_width_m); }
  /// Counter-clockwise from the front left.
  std::array<Eigen::Vector2d, 4> corners() const {
    return {{{front_m, half_width_m},
             {-rear_m, half_width_m},
             {-rear_m, -half_width_m},
             {front_m, -half_width_m}}};
  }
  /// From a point of the robot's frame; 0 inside.
  double distance_m(const Eigen::Vector2d& p_R) const {
    return std::hypot(std::max({p_R.x() - front_m, -rear_m - p_R.x(), 0.0}),
                      std::max(std::abs(p_R.y()) - half_width_m, 0.0));
  }
};

/// Pioneer 3-DX: 425 mm x 511 mm.
inline constexpr Footprint pioneer_3dx_footprint{};

/// How wrong dead reckoning may be: the bound that the robot's makers state and everybody else relies on.
/// Between two moments, with the true path length s and the true turned angle |turn|, both summed without
/// sign; the twist errs by no more than the same bounds per second:
///   error of the path's length  <= distance_share * s
///   error of the heading        <= turn_share * |turn| + turn_per_m * s
struct OdometryBound {
  double distance_share = 0;    ///< m per m
  double turn_share = 0;        ///< rad per rad
  double turn_per_m_radpm = 0;  ///< rad per m

  /// The errors of path or speed and of turn or turning rate, at most, where so much was *measured*.
  Twist2 error_of(double path, double turn) const {
    const double true_path = path / (1.0 - distance_share);  // at most
    return {distance_share * true_path,
            (turn_share * turn + turn_per_m_radpm * true_path) / (1.0 - turn_share)};
  }
  /// Bound (m) on the error of where a resting point stands relative to the robot, after the measured path
  /// and turn since it was seen; `distance_m` is the point's distance from the axle now. Where the robot
  /// believes it, p, changes by v and w x p, so its error grows by at most |dv| + |dw| |p|, and |p| was never
  /// more than distance_m + path_m.
  double point_error_m(double path_m, double turn_rad, double distance_m) const {
    const Twist2 error = error_of(path_m, turn_rad);
    return error.v_mps + error.w_radps * (distance_m + path_m);
  }
  /// Of the twists that may have been measured so, the one nearest to `expected`.
  Twist2 nearest_true(const Twist2& measured, const Twist2& expected) const {
    const Twist2 error = error_of(std::abs(measured.v_mps), std::abs(measured.w_radps));
    return {std::clamp(expected.v_mps, measured.v_mps - error.v_mps, measured.v_mps + error.v_mps),
            std::clamp(expected.w_radps, measured.w_radps - error.w_radps, measured.w_radps + error.w_radps)};
  }
};
void declare(OptionVisitor& v, OdometryBound& bound);

/// The same angle in (-pi, pi]; NaN stays NaN.
double wrap_angle(double angle_rad);

/// The pose after moving with a constant twist for dt_s: exactly along its arc (Siegwart, Nourbakhsh and
/// Scaramuzza, "Introduction to Autonomous Mobile Robots", 3.2), a straight line for w = 0. Yaw is not
/// wrapped. dt_s may be negative.
Pose2 integrate(const Pose2& pose, const Twist2& twist, double dt_s);

/// The twist scaled down as a whole, so that both speeds keep their limits and the path its curvature.
Twist2 limit_speed(const Twist2& command, const UnicycleLimits& limits);

/// The twist that the drive reaches dt_s after `current` when told `command` (the command's speeds are
/// limited first). Of all twists within reach: the command itself if it is one; else one of the command's
/// curvature, as near to its speed as can be; if there is none, each speed goes as far towards the command's
/// as it can. A command to stand still brakes both speeds in proportion: the robot stays on its arc until it
/// stands.
Twist2 limit_acceleration(const Twist2& current, const Twist2& command, const UnicycleLimits& limits,
                          double dt_s);

/// The robot at one instant.
struct RobotMotion {
  Pose2 pose;
  Twist2 twist;
};

inline Twist2 mean_twist(const Twist2& a, const Twist2& b) {
  return {0.5 * (a.v_mps + b.v_mps), 0.5 * (a.w_radps + b.w_radps)};
}

/// A drive's model goes in steps of at most this.
inline constexpr double drive_step_s = 0.002;

/// The robot after one command was held for dt_s. The twist changes over it, so in so many steps, each an arc
/// of its mean twist.
RobotMotion drive(RobotMotion robot, const Twist2& command, const UnicycleLimits& limits, double dt_s,
                  int steps);

/// Share of the drive's deceleration that the envelope counts on. The rest is for a drive that brakes less
/// than its model says.
inline constexpr double envelope_braking_share = 0.85;

/// The envelope takes errors as larger by these. Its slope at an error of 0 is then sqrt(share a / (2
/// slack)), not infinite: 8 per second for the Pioneer's drive, four times the default gain of the laws.
inline constexpr double range_slack_m = 0.002, bearing_slack_rad = 0.01;

/// How long the drive brakes from that twist to rest.
inline double braking_time_s(const Twist2& twist, const UnicycleLimits& limits) {
  return std::max(std::abs(twist.v_mps) / limits.a_max_mps2,
                  std::abs(twist.w_radps) / limits.alpha_max_radps2);
}

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

/// The third component of the cross product of two vectors of a plane.
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// X_WR as a transform of space.
Eigen::Isometry3d X_WR(const Pose2& pose);

/// A point of the floor plane seen from the robot: p_RP from p_WP (m).
Eigen::Vector2d in_robot_frame(const Pose2& pose, const Eigen::Vector2d& p_W);

/// A point of the robot's plane in the world: p_WP from p_RP (m).
Eigen::Vector2d in_world_frame(const Pose2& pose, const Eigen::Vector2d& p_R);

}  // namespace ballservo
