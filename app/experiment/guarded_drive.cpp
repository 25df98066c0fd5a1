#include "app/experiment/guarded_drive.hpp"

#include <algorithm>
#include <utility>

namespace ballservo {

namespace {

bool rests(const Twist2& command) { return command.v_mps == 0.0 && command.w_radps == 0.0; }

bool passes(const Twist2& command, const GuardVerdict& verdict) {
  return rests(command) || (!verdict.stop && (verdict.forward || command.v_mps <= 0.0) &&
                            (verdict.backward || command.v_mps >= 0.0));
}

}  // namespace

/// The robot at now, its sonars fired on the way; the mutex is held.
double GuardedDrive::move_on() {
  const double now_s = std::max(clock_.now_s(), robot_.time_s());
  while (robot_.next_sonar_s() <= now_s) {
    robot_.advance_to(robot_.next_sonar_s());
    robot_.fire_sonar();
  }
  robot_.advance_to(now_s);
  return now_s;
}

void GuardedDrive::tell(double now_s, const Twist2& command, bool by_guard) {
  robot_.command(command);
  followed_ = command;
  commands_.push_back({now_s, command, by_guard});
  if (by_guard && !rested_s_) rested_s_ = now_s;
}

RobotView GuardedDrive::look() {
  const std::lock_guard<std::mutex> lock(mutex_);
  move_on();
  return robot_.view();
}

std::vector<SonarReading> GuardedDrive::listen() {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::vector<SonarReading> heard;
  robot_.listen([&heard](const SonarReading& reading) { heard.push_back(reading); });
  return heard;
}

void GuardedDrive::command(const Twist2& command, const SensorStamps& stamps) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now_s = move_on();
  stamps_ = stamps;
  const bool stopped = !passes(command, guard(now_s, stamps_, options_));
  tell(now_s, stopped ? Twist2{} : command, stopped);
}

void GuardedDrive::guard_now() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now_s = move_on();
  if (!passes(followed_, guard(now_s, stamps_, options_))) tell(now_s, {}, true);
}

std::optional<double> GuardedDrive::rested_since_asked() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(rested_s_, std::nullopt);
}

}  // namespace ballservo
