// The plane kinematics of a robot with two driven wheels.
//
// Robot frame R: x forward, y left, z up, origin on the floor under the middle of the axle. World frame W: z
// up, floor at z = 0. Yaw counts from the world's x axis, counter-clockwise seen from above.
#pragma once

#include <Eigen/Geometry>

namespace ballservo {

class OptionVisitor;

/// Where the robot stands: X_WR in the plane.
struct Pose2 {
  double x_m = 0, y_m = 0, yaw_rad = 0;
};

/// How it moves: forward speed and turning rate (counter-clockwise positive), in the robot frame.
struct Twist2 {
  double v_mps = 0, w_radps = 0;
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
};

/// Pioneer 3-DX: 425 mm x 511 mm.
inline constexpr Footprint pioneer_3dx_footprint{};

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

/// X_WR as a transform of space.
Eigen::Isometry3d X_WR(const Pose2& pose);

/// A point of the floor plane seen from the robot: p_RP from p_WP (m).
Eigen::Vector2d in_robot_frame(const Pose2& pose, const Eigen::Vector2d& p_W);

/// A point of the robot's plane in the world: p_WP from p_RP (m).
Eigen::Vector2d in_world_frame(const Pose2& pose, const Eigen::Vector2d& p_R);

}  // namespace ballservo
