#include "servo/avoidance/braking_shield.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

constexpr double place_spacing_m = 0.02;  // between places looked at, as the outermost corner moves
constexpr double creeping_mps = 0.10, creeping_radps = 0.30;

}  // namespace

Brake can_brake_after(const Twist2& command, const RobotMotion& when_it_acts, const OccupancyGrid& grid,
                      const ShieldOptions& options, const MovingThings* moving) {
  const double margin_m = drive_model_m + 0.5 * place_spacing_m;
  const double corner_m = options.footprint.reach_m();
  const auto rate_mps = [corner_m](const Twist2& twist) {
    return std::abs(twist.v_mps) + std::abs(twist.w_radps) * corner_m;
  };
  const int steps = static_cast<int>(std::ceil(options.period_s / drive_step_s));
  const double step_s = options.period_s / steps;
  const double brakes_s = options.delay_s + options.period_s;
  // A place stands for the way until half the spacing later, the last part of a brake at most.
  const UnicycleLimits& limits = options.limits;
  const double lingers_s = std::sqrt(
      place_spacing_m * std::max(1.0 / limits.a_max_mps2, 1.0 / (limits.alpha_max_radps2 * corner_m)));
  RobotMotion after;  // the command's period

  // No place along the way is further than half the spacing from one that is looked at.
  const auto clear = [&](OccupancyGrid::Drift drift, const Pose2* standing) {
    const auto covers = [&](const Pose2& pose, double later_s) {
      return grid.covers(options.footprint, pose, margin_m, drift, standing) &&
             (moving == nullptr || !moving->may_touch(options.footprint, pose, margin_m, later_s));
    };
    after = when_it_acts;
    double to_next_m = 0.5 * place_spacing_m;
    for (int k = 0; k < steps; ++k) {
      const RobotMotion next = drive(after, command, limits, step_s, 1);
      const double step_m = step_s * rate_mps(mean_twist(after.twist, next.twist));
      if (!(step_m < to_next_m)) {
        if (!(step_m < place_spacing_m) || !covers(after.pose, brakes_s + lingers_s)) return false;
        to_next_m = place_spacing_m;
      }
      to_next_m -= step_m;
      after = next;
    }
    // The brake: both speeds fall in proportion, so the robot stays on one arc.
    const double brake_s = braking_time_s(after.twist, limits);
    const double way_m = 0.5 * brake_s * rate_mps(after.twist);
    double at_m = to_next_m;
    for (; at_m < way_m; at_m += place_spacing_m) {
      const double left = std::max(0.0, 1.0 - (at_m + 0.5 * place_spacing_m) / way_m);
      if (!covers(integrate(after.pose, after.twist, 0.5 * brake_s * at_m / way_m),
                  brakes_s + brake_s * (1.0 - std::sqrt(left))))
        return false;
    }
    return at_m - way_m > 0.5 * place_spacing_m ||
           covers(integrate(after.pose, after.twist, 0.5 * brake_s), brakes_s + brake_s);
  };
  // What was seen lately needs less clearance around the robot than what is half forgotten.
  if (clear(OccupancyGrid::Drift::allowed, nullptr) || clear(OccupancyGrid::Drift::close, nullptr))
    return Brake::free;
  // Where space close to the robot has been forgotten, it may creep away from it.
  const bool creeps = options.creep && std::abs(after.twist.v_mps) <= creeping_mps &&
                      std::abs(after.twist.w_radps) <= creeping_radps &&
                      (clear(OccupancyGrid::Drift::allowed, &when_it_acts.pose) ||
                       clear(OccupancyGrid::Drift::close, &when_it_acts.pose));
  return creeps ? Brake::creeping : Brake::blocked;
}

ShieldVerdict shield(const Twist2& command, const RobotMotion& when_it_acts, const OccupancyGrid& grid,
                     const ShieldOptions& options, const MovingThings* moving) {
  ShieldVerdict verdict;
  const bool sane = command.is_finite() && when_it_acts.twist.is_finite() &&
                    std::isfinite(when_it_acts.pose.x_m) && std::isfinite(when_it_acts.pose.y_m) &&
                    std::isfinite(when_it_acts.pose.yaw_rad);
  if (!sane) {
    verdict.passed = false;
    verdict.reason = "a command or a motion is not finite";
    return verdict;
  }
  verdict.command = command;
  if (command.rests()) return verdict;
  const auto passes = [&] {
    const Brake brake = can_brake_after(verdict.command, when_it_acts, grid, options, moving);
    if (brake == Brake::creeping) verdict.reason = creeping_reason;
    return brake != Brake::blocked;
  };
  if (passes()) return verdict;
  verdict.passed = false;
  for (const double share : {0.7, 0.4, 0.15}) {
    verdict.command = {share * command.v_mps, share * command.w_radps};
    verdict.reason = "slowed: the brake would leave the space seen free";
    if (passes()) return verdict;
  }
  // The least turn comes nearer to what has been forgotten along a flank.
  verdict.command = {std::clamp(command.v_mps, -creeping_mps, creeping_mps), 0.0};
  verdict.reason = "straight on: a turn would leave the space seen free";
  if (command.v_mps != 0.0 && passes()) return verdict;
  verdict.command = {0.0, command.w_radps};
  verdict.reason = "turning only: ahead is not seen free";
  if (command.w_radps != 0.0 && passes()) return verdict;
  verdict.command = {};
  verdict.reason = "stopped: what lies ahead is not seen free";
  return verdict;
}

}  // namespace ballservo
