#include "servo/avoidance/braking_shield.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ballservo {

namespace {

constexpr double spacing_m = 0.02;  // between places looked at, as the outermost corner moves
constexpr double creeping_mps = 0.10, creeping_radps = 0.30;

bool finite(const Twist2& twist) { return std::isfinite(twist.v_mps) && std::isfinite(twist.w_radps); }

}  // namespace

Brake can_brake_after(const Twist2& command, const RobotMotion& when_it_acts, const OccupancyGrid& grid,
                      const ShieldOptions& options, FloorCell* blocked) {
  const double margin_m = drive_model_m + 0.5 * spacing_m;
  const double corner = options.footprint.reach_m();

  // The command's period, then the brake: both speeds fall in proportion, so the robot stays on one arc.
  const Twist2 from = when_it_acts.twist;
  const Twist2 after = limit_acceleration(from, command, options.limits, options.period_s);
  const Twist2 mean = mean_twist(from, after);
  const Pose2 start = integrate(when_it_acts.pose, mean, options.period_s);
  const auto places_on = [corner](const Twist2& twist, double time_s) {
    const double way_m = time_s * (std::abs(twist.v_mps) + std::abs(twist.w_radps) * corner);
    return std::max(1, static_cast<int>(std::ceil(way_m / spacing_m)));
  };
  const double brake_s = std::max(std::abs(after.v_mps) / options.limits.a_max_mps2,
                                  std::abs(after.w_radps) / options.limits.alpha_max_radps2);
  const int driven = places_on(mean, options.period_s), braked = places_on(after, 0.5 * brake_s);
  const auto clear = [&](OccupancyGrid::Drift drift, const Pose2* standing) {
    for (int k = 1; k <= driven + braked; ++k) {
      const Pose2 pose = k <= driven ? integrate(when_it_acts.pose, mean, options.period_s * k / driven)
                                     : integrate(start, after, 0.5 * brake_s * (k - driven) / braked);
      if (!grid.covers(options.footprint, pose, margin_m, drift, blocked, standing)) return false;
    }
    return true;
  };
  // What was seen lately needs less clearance around the robot than what is half forgotten.
  if (clear(OccupancyGrid::Drift::allowed, nullptr) || clear(OccupancyGrid::Drift::close, nullptr))
    return Brake::free;
  // Where space close to the robot has been forgotten, it may creep away from it.
  const bool creeps = options.creep && std::abs(after.v_mps) <= creeping_mps &&
                      std::abs(after.w_radps) <= creeping_radps &&
                      (clear(OccupancyGrid::Drift::allowed, &when_it_acts.pose) ||
                       clear(OccupancyGrid::Drift::close, &when_it_acts.pose));
  return creeps ? Brake::creeping : Brake::blocked;
}

ShieldVerdict shield(const Twist2& command, const RobotMotion& when_it_acts, const OccupancyGrid& grid,
                     const ShieldOptions& options) {
  ShieldVerdict verdict;
  const bool sane = finite(command) && finite(when_it_acts.twist) && std::isfinite(when_it_acts.pose.x_m) &&
                    std::isfinite(when_it_acts.pose.y_m) && std::isfinite(when_it_acts.pose.yaw_rad);
  if (!sane) {
    verdict.passed = false;
    verdict.reason = "a command or a motion is not finite";
    return verdict;
  }
  verdict.command = command;
  if (command.v_mps == 0.0 && command.w_radps == 0.0) return verdict;
  FloorCell cell;
  const auto passes = [&](FloorCell* blocked) {
    const Brake brake = can_brake_after(verdict.command, when_it_acts, grid, options, blocked);
    if (brake == Brake::creeping) verdict.reason = creeping_reason;
    return brake != Brake::blocked;
  };
  if (passes(&cell)) return verdict;
  verdict.passed = false;
  verdict.blocked = cell;
  for (const double share : {0.7, 0.4, 0.15}) {
    verdict.command = {share * command.v_mps, share * command.w_radps};
    verdict.reason = "slowed: the brake would leave the space seen free";
    if (passes(nullptr)) return verdict;
  }
  // The least turn comes nearer to what has been forgotten along a flank.
  verdict.command = {std::clamp(command.v_mps, -creeping_mps, creeping_mps), 0.0};
  verdict.reason = "straight on: a turn would leave the space seen free";
  if (command.v_mps != 0.0 && passes(nullptr)) return verdict;
  verdict.command = {0.0, command.w_radps};
  verdict.reason = "turning only: ahead is not seen free";
  if (command.w_radps != 0.0 && passes(nullptr)) return verdict;
  verdict.command = {};
  verdict.reason = "stopped: what lies ahead is not seen free";
  return verdict;
}

}  // namespace ballservo
