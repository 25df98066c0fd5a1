#include "app/loop/guarded_robot.hpp"

#include <utility>

namespace ballservo {

RobotState GuardedRobot::read(double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (const auto rested_s = std::exchange(rested_s_, std::nullopt)) ports_.controller.rested(*rested_s);
  return ports_.robot.read(now_s);
}

void GuardedRobot::listen(const std::function<void(const SonarReading&)>& hear) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ports_.robot.listen(hear);
}

void GuardedRobot::command(const Twist2& twist, double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stamps_ = ports_.controller.stamps();
  // What the guard has overtaken rests on a motion that is no longer the robot's.
  if (rested_s_ || !passes(twist, now_s)) return rest(now_s);
  ports_.robot.command(twist, now_s);
  followed_ = twist;
}

void GuardedRobot::pan(double speed_radps, double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ports_.robot.pan(speed_radps, now_s);
}

void GuardedRobot::guard_now() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now_s = clock_.now_s();
  if (!passes(followed_, now_s)) rest(now_s);
}

bool GuardedRobot::passes(const Twist2& twist, double now_s) const {
  if (twist.rests()) return true;
  const GuardVerdict verdict = guard(now_s, stamps_, options_);
  return !verdict.stop && (verdict.forward || twist.v_mps <= 0.0) && (verdict.backward || twist.v_mps >= 0.0);
}

/// The mutex is held.
void GuardedRobot::rest(double now_s) {
  ports_.robot.command({}, now_s);
  ports_.robot.pan(0, now_s);
  followed_ = {};
  if (!rested_s_) rested_s_ = now_s;
  for (LoopObserver* each : ports_.observers) each->guard_rested(now_s);
}

}  // namespace ballservo
