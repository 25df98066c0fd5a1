#include "servo/avoidance/sonar.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

// The transducers that look where the robot goes when it drives ahead, and when it backs up.
constexpr std::array<std::size_t, 4> ahead{2, 3, 4, 5}, astern{10, 11, 12, 13};
constexpr double stale_vision_s = 0.2;   // six frames at 30 Hz: stand still without one for so long
constexpr double silent_array_s = 0.12;  // three firings of an array
constexpr double old_look_s = 0.7;  // two rounds of an array: no motion into a sector last looked at earlier
constexpr double late_s = 0.12;     // answers older than this on arrival are not believed
constexpr int stuck_after = 4;      // equal ranges in a row while the robot moves are not believed
constexpr double stuck_way_m = 0.05;  // equal ranges mean nothing while the robot rests

bool sane(const SonarReading& reading) {
  return reading.transducer < sonar_count && std::isfinite(reading.range_m) &&
         std::isfinite(reading.fired_s) && reading.range_m >= 0.0;
}

/// Older than `age_s`, or of a time that cannot be.
bool old(double now_s, double stamp_s, double age_s) {
  return !(now_s - stamp_s <= age_s && now_s - stamp_s >= 0.0);
}

bool any_old(double now_s, const SensorStamps& stamps, const std::array<std::size_t, 4>& transducers) {
  return std::any_of(transducers.begin(), transducers.end(),
                     [&](std::size_t k) { return old(now_s, stamps.looked_s[k], old_look_s); });
}

}  // namespace

void declare(OptionVisitor& v, SonarBeam& beam) {
  v.number("min_range_m", beam.min_range_m, NumberRange::above(0, 1, "m"), "nothing nearer is heard");
  v.number("max_range_m", beam.max_range_m, NumberRange::within(1, 10, "m"), "nothing further is heard");
  v.number("half_angle_rad", beam.half_angle_rad, NumberRange::within(0.02, 0.7, "rad"),
           "of the cone in which things echo");
}

std::optional<Pose2> transducer_of(const SonarReading& reading, const Pose2& robot) {
  if (!sane(reading)) return std::nullopt;
  const SonarMount& mount = pioneer_3dx_sonars[reading.transducer];
  const Eigen::Vector2d p = in_world_frame(robot, {mount.x_m, mount.y_m});
  return Pose2{p.x(), p.y(), robot.yaw_rad + mount.heading_rad};
}

GuardVerdict guard(double now_s, const SensorStamps& stamps, const GuardOptions& options) {
  if (!std::isfinite(now_s)) return {true, false, false, "guard: the clock is not finite"};
  if (old(now_s, stamps.frame_s, stale_vision_s)) {
    return {true, false, false, "guard: no frames from the camera"};
  }
  if (old(now_s, stamps.step_s, options.stale_step_s)) {
    return {true, false, false, "guard: the controller is silent"};
  }
  GuardVerdict verdict;
  if (!options.sonars) return verdict;
  const bool front_silent = old(now_s, stamps.array_heard_s[0], silent_array_s);
  const bool rear_silent = old(now_s, stamps.array_heard_s[1], silent_array_s);
  if (any_old(now_s, stamps, astern) || rear_silent) {
    verdict.backward = false;
    verdict.reason = "guard: not looked behind for too long";
  }
  if (any_old(now_s, stamps, ahead)) {
    verdict.forward = false;
    verdict.reason = "guard: not looked ahead for too long";
  }
  if (front_silent || rear_silent) {
    verdict.forward = false;
    verdict.reason =
        front_silent ? "guard: the front sonars are silent" : "guard: the rear sonars are silent";
  }
  return verdict;
}

bool SonarWatch::hear(const SonarReading& reading, double now_s, double way) {
  if (!sane(reading) || !(reading.fired_s <= now_s)) return false;
  stamps_.array_heard_s[reading.transducer / 8] = now_s;
  if (now_s - reading.fired_s > late_s) return false;
  Repeat& repeat = repeats_[reading.transducer];
  if (reading.echo && reading.range_m == repeat.range_m) {
    ++repeat.count;
  } else {
    repeat = {reading.range_m, way, 1};
  }
  if (reading.echo && repeat.count >= stuck_after && way - repeat.way > stuck_way_m) return false;
  stamps_.looked_s[reading.transducer] = reading.fired_s;
  return true;
}

}  // namespace ballservo
