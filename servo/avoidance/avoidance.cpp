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
  if (options.moving.speed_mps > 0.0) moving_.emplace(options.moving, options.grid, shield_);
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
  if (moving_) {
    moving_->things.move(now_s, pose);
    if (steers()) moving_->tracker.move(now_s);
  }
  if (map_) map_->move(pose);
  for (std::size_t k = 0; k < readings_.count; ++k) {
    const SonarReading& reading = readings_.messages[k];
    if (!watch_.hear(reading, now_s, way_m_)) continue;
    const auto pose_then = pose_at(poses, reading.fired_s);
    if (!pose_then) continue;
    grid_.look(reading, *pose_then);
    if (moving_) {
      moving_->things.look(reading, *pose_then);
      if (steers()) moving_->tracker.look(reading, *pose_then);
    }
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
  if (!moving_) return output;
  // Twice between two plans of a way, so that no step pays for both.
  const unsigned step = moving_->steps++ % Steering::plan_every;
  if (step == 1 || step == 3) {
    moving_->evasive = moving_->evasion.command(output.command, input.when_it_acts, moving_->tracker.movers(),
                                                grid_, moving_->things);
  }
  if (moving_->evasive) {
    output.command = *moving_->evasive;
    output.reason = "something comes: keeping out of its way";
  }
  return output;
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
  ShieldVerdict verdict = shield(guarded, when_it_acts, grid_, shield_, moving_ ? &moving_->things : nullptr);
  const bool changed = guarded.v_mps != command.v_mps || guarded.w_radps != command.w_radps;
  if (changed && verdict.passed) {
    verdict.passed = false;
    if (verdict.reason.empty()) verdict.reason = allowed.reason;
  }
  last_ = verdict;
  return verdict;
}

}  // namespace ballservo
