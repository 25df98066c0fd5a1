// Whether a scenario's task can be done at all: worlds that cannot are counted apart; and how fast the run
// could have been.
#pragma once

#include <string>

#include "app/scenario/scenario.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// Why the robot cannot reach its goal, for people: PathPlanner proves that the robot cannot get from its
/// start to a place from which it sees the ball at the desired distance; for a ball that moves, at some full
/// second of the run. Empty where there is no such proof.
std::string why_infeasible(const Scenario& scenario);

/// The shortest time (s) in which a speed-limited, acceleration-limited axis moves by `way` from rest to
/// rest: up, level where the limit is reached, down (trapezoid; Biagiotti and Melchiorri, "Trajectory
/// Planning for Automatic Machines and Robots", 3.2).
double rest_to_rest_s(double way, double speed_limit, double acceleration_limit);

/// Turn towards the ball on the spot, then straight to `distance_m` from it, both rest to rest at full
/// acceleration, without delay: the time-optimal run of a robot that turns before it drives. One that turns
/// while it drives may take less.
double time_optimal_s(const Pose2& start, const Eigen::Vector2d& p_WB, double distance_m,
                      const UnicycleLimits& limits);

}  // namespace ballservo
