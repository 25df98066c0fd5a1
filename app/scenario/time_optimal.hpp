// How fast the run could have been: the yardstick for settling times.
#pragma once

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// The shortest time (s) in which a speed-limited, acceleration-limited axis moves by `way` from rest to
/// rest: up, level where the limit is reached, down (trapezoid; Biagiotti and Melchiorri, "Trajectory
/// Planning for Automatic Machines and Robots", 3.2).
double rest_to_rest_s(double way, double speed_limit, double acceleration_limit);

/// Turn towards the ball on the spot, then straight to `distance_m` from it, both rest to rest at full
/// acceleration, without delay: the time-optimal run of a robot that turns before it drives.
double time_optimal_s(const Pose2& start, const Eigen::Vector2d& p_WB, double distance_m,
                      const UnicycleLimits& limits);

}  // namespace ballservo
