#include "servo/avoidance/avoidance.hpp"

#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

void declare(OptionVisitor& v, AvoidanceOptions& avoidance) {
  v.boolean("creep", avoidance.creep, "slow commands may pass by the rule of creeping away (SAFETY.md)");
  v.boolean("floor", avoidance.floor, "what the camera sees standing on the floor is not free");
  declare(v, avoidance.grid);
  v.map("moving", [&] { declare(v, avoidance.moving); });
}

Avoidance::Avoidance(const AvoidanceOptions& options, const UnicycleLimits& limits, double delay_s,
                     double period_s)
    : options_(options),
      shield_{limits, options.grid.footprint, delay_s, period_s, options.creep},
      grid_(options.grid) {
  if (options.moving.speed_mps > 0.0) moving_.emplace(options.moving, options.grid);
  if (options.type == AvoidanceOptions::Type::full) {
    map_.emplace(options.grid);
    steering_.emplace(options.half_view_rad, limits, options.grid.footprint);
  }
}

void Avoidance::update(double now_s, const Pose2& pose, const PoseHistory& poses) {
  if (pose_) {
    way_m_ += distance_m(*pose_, pose) + 0.3 * std::abs(wrap_angle(pose.yaw_rad - pose_->yaw_rad));
  } else {
    frame_s_ = now_s;  // the first frame is awaited from here on
  }
  pose_ = pose;
  grid_.move(now_s, pose);
  if (moving_) moving_->move(now_s, pose);
  if (map_) map_->move(pose);
  for (std::size_t k = 0; k < readings_.count; ++k) {
    const SonarReading& reading = readings_.messages[k];
    if (!watch_.hear(reading, now_s, way_m_)) continue;
    const auto pose_then = pose_at(poses, reading.fired_s);
    if (!pose_then) continue;
    grid_.look(reading, *pose_then);
    if (moving_) moving_->look(reading, *pose_then);
    if (map_) map_->look(reading, *pose_then);
  }
  for (std::size_t k = 0; k < scans_.count; ++k) {
    const FloorScan& scan = scans_.messages[k];
    const auto pose_then = pose_at(poses, scan.time_s);
    if (!pose_then) continue;
    grid_.look_at_floor(scan, *pose_then);
    if (map_) map_->look_at_floor(scan, *pose_then);
  }
  readings_.count = scans_.count = 0;
  if (map_ && frame_s_ > viewed_s_)
    viewed_.look({pose.x_m, pose.y_m, pose.yaw_rad + pan_rad_}, options_.half_view_rad, *map_);
  viewed_s_ = frame_s_;
}

SteeringOutput Avoidance::steer(const SteeringInput& input) {
  SteeringOutput output = steering_->steer(input, *map_, grid_, last_);
  if (!moving_ || !moving_->something_comes()) return output;
  if (const auto command = out_of_the_way(output.command, input.when_it_acts)) {
    output.command = *command;
    output.reason = "something comes: keeping out of its way";
  }
  return output;
}

/// Where driving as wanted for a second would end close to what moves: the command after which more room is
/// left than after any other that passes the shield.
std::optional<Twist2> Avoidance::out_of_the_way(const Twist2& wanted, const RobotMotion& when_it_acts) const {
  constexpr double drives_s = 1.0, enough_m = 0.7, better_m = 0.05;
  const UnicycleLimits& limits = shield_.limits;
  const auto ends_at = [&](const Twist2& command) {
    const RobotMotion driven = drive(when_it_acts, command, limits, drives_s, 10);
    return integrate(driven.pose, driven.twist, 0.5 * braking_time_s(driven.twist, limits));
  };
  std::optional<Twist2> best;
  double best_m = moving_->clearance_m(shield_.footprint, ends_at(wanted));
  if (best_m > enough_m) return best;
  for (const double v_mps : {0.0, -0.3, 0.3, -0.6, 0.6}) {
    for (const double w_radps : {0.0, 0.5, -0.5}) {
      const Twist2 command{v_mps, w_radps};
      const Pose2 end = ends_at(command);
      const Twist2 next = limit_acceleration(when_it_acts.twist, command, limits, 0.1);
      if (moving_->may_touch(shield_.footprint, end, best_m + better_m, 0) ||
          can_brake_after(next, when_it_acts, grid_, shield_, &*moving_) == Brake::blocked)
        continue;
      best_m = moving_->clearance_m(shield_.footprint, end);
      best = command;
    }
  }
  return best;
}

bool Avoidance::has_seen_all_from_here() const {
  constexpr double little_m2 = 0.3;
  return viewed_.new_from_m2({grid_.pose().x_m, grid_.pose().y_m}, *map_) < little_m2;
}

ShieldVerdict Avoidance::check(double now_s, const Twist2& command, const RobotMotion& when_it_acts) {
  SensorStamps stamps = watch_.stamps();
  stamps.frame_s = frame_s_;
  stamps.step_s = now_s;
  const GuardVerdict allowed = guard(now_s, stamps, {});
  Twist2 guarded = command;
  if (!allowed.forward && guarded.v_mps > 0.0) guarded.v_mps = 0.0;
  if (!allowed.backward && guarded.v_mps < 0.0) guarded.v_mps = 0.0;
  if (allowed.stop) guarded = {};
  ShieldVerdict verdict = shield(guarded, when_it_acts, grid_, shield_, moving_ ? &*moving_ : nullptr);
  const bool changed = guarded.v_mps != command.v_mps || guarded.w_radps != command.w_radps;
  if (changed && verdict.passed) {
    verdict.passed = false;
    if (verdict.reason.empty()) verdict.reason = allowed.reason;
  }
  last_ = verdict;
  return verdict;
}

}  // namespace ballservo
