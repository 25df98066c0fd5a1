// The last word on every command: it passes only if the robot can brake afterwards within space that was seen
// free.
#pragma once

#include <string_view>

#include "servo/avoidance/moving_things.hpp"
#include "servo/avoidance/occupancy_grid.hpp"
#include "servo/motion/motion_history.hpp"

namespace ballservo {

/// Bound on how far the robot leaves the path that the model of its drive predicts: assumption A6 of
/// SAFETY.md.
inline constexpr double drive_model_m = 0.01;

struct ShieldOptions {
  UnicycleLimits limits;
  Footprint footprint;
  double delay_s = 0;      ///< from now until a command acts
  double period_s = 0.02;  ///< a command drives at most so long before the next one, or rest, takes over
  bool creep = true;       ///< slow commands may pass by the rule of creeping away (SAFETY.md)
};

/// The verdict's reason where a command passed by the rule of creeping away.
inline constexpr std::string_view creeping_reason = "creeping away from what is not seen free";

/// What became of a command.
struct ShieldVerdict {
  Twist2 command;           ///< never faster than what was asked for, in either part
  bool passed = true;       ///< as it was asked for
  std::string_view reason;  ///< empty where it passed by what was seen free; a literal
};

/// A pure function of its arguments. Of a command (v, w) it lets pass the first of (v, w), less of both, (v,
/// 0) no faster than it creeps, (0, w) and (0, 0) after which the robot, driven for a period and then braked
/// to rest, stays in free space: the footprint, grown by the drift of odometry that `grid` allows, by the
/// model's error and by the way between two places looked at. (0, 0) needs no test: it is the brake that was
/// part of the test of the command before.
ShieldVerdict shield(const Twist2& command, const RobotMotion& when_it_acts, const OccupancyGrid& grid,
                     const ShieldOptions& options, const MovingThings* moving = nullptr);

/// Whether the robot, from that motion, can be driven by the command for a period and then brake to rest:
/// within free space, or by creeping away from what is not seen free.
enum class Brake { blocked, creeping, free };
Brake can_brake_after(const Twist2& command, const RobotMotion& when_it_acts, const OccupancyGrid& grid,
                      const ShieldOptions& options, const MovingThings* moving = nullptr);

}  // namespace ballservo
