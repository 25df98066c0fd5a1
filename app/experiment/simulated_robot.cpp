#include "app/experiment/simulated_robot.hpp"

#include <algorithm>

namespace ballservo {

namespace {

UnicycleLimits true_limits(const RobotSettings& robot) {
  UnicycleLimits limits = robot.limits;
  limits.a_max_mps2 *= robot.acceleration_share;
  limits.alpha_max_radps2 *= robot.acceleration_share;
  return limits;
}

}  // namespace

SimulatedRobot::SimulatedRobot(const World& world, const RobotSettings& settings, std::uint64_t seed)
    : drive_(settings.pose, true_limits(settings), settings.actuation_delay_s),
      odometry_(settings.odometry, settings.pose, seed) {
  if (settings.sonar) sonar_.emplace(world, *settings.sonar, settings.sonar_faults, seed);
}

/// The mutex is held.
void SimulatedRobot::move_on(double now_s) {
  const auto move_to = [this](double time_s) {
    drive_.advance_to(time_s);
    odometry_.move(drive_.pose());
  };
  now_s = std::max(now_s, drive_.time_s());
  while (sonar_ && sonar_->next_s() <= now_s) {
    move_to(sonar_->next_s());
    if (const auto firing = sonar_->fire(drive_.pose())) firings_.push_back(*firing);
  }
  move_to(now_s);
}

RobotTruth SimulatedRobot::at(double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  move_on(now_s);
  return {drive_.time_s(), drive_.pose(), drive_.twist()};
}

RobotState SimulatedRobot::read(double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  move_on(now_s);
  when_read_ = {drive_.time_s(), drive_.pose(), drive_.twist()};
  return {drive_.time_s(), odometry_.pose(), odometry_.measure(drive_.twist())};
}

void SimulatedRobot::command(const Twist2& twist, double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (now_s > drive_.time_s()) move_on(now_s);
  drive_.command(twist);
  commands_.push_back({drive_.time_s(), twist});
}

void SimulatedRobot::put(const Pose2& pose) {
  const std::lock_guard<std::mutex> lock(mutex_);
  drive_.put(pose);
  odometry_.put(pose);
}

void SimulatedRobot::look_around() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (sonar_) sonar_->look_around();
}

void SimulatedRobot::listen(const std::function<void(const SonarReading&)>& hear) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (sonar_) sonar_->deliver(drive_.time_s(), hear);
}

}  // namespace ballservo
