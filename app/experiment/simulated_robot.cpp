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

PanMotion SimulatedPan::advance_to(double time_s) {
  const RobotMotion turned = drive_.advance_to(time_s);
  const double angle_rad = std::clamp(turned.pose.yaw_rad, -max_rad_, max_rad_);
  if (angle_rad == turned.pose.yaw_rad) return {angle_rad, turned.twist.w_radps};
  drive_.hold({0, 0, angle_rad});
  return {angle_rad, 0};
}

SimulatedRobot::SimulatedRobot(const World& world, const RobotSettings& settings, std::uint64_t seed,
                               std::shared_ptr<RobotBody> body, const PanLimits& pan)
    : body_(body ? std::move(body)
                 : std::make_shared<UnicycleRobot>(settings.pose, true_limits(settings),
                                                   settings.actuation_delay_s)),
      odometry_(settings.odometry, settings.pose, seed) {
  if (pan.turns()) pan_.emplace(pan, settings.actuation_delay_s);
  const RobotMotion start = body_->advance_to(0);
  now_ = {0, start.pose, start.twist};
  odometry_.put(start.pose);
  if (settings.sonar) sonar_.emplace(world, *settings.sonar, settings.sonar_faults, seed);
}

/// The mutex is held.
void SimulatedRobot::move_on(double now_s) {
  const auto move_to = [this](double time_s) {
    const RobotMotion motion = body_->advance_to(time_s);
    now_ = {time_s, motion.pose, motion.twist, pan_ ? pan_->advance_to(time_s) : PanMotion{}};
    odometry_.move(now_.pose);
  };
  now_s = std::max(now_s, now_.time_s);
  while (sonar_ && sonar_->next_s() <= now_s) {
    move_to(sonar_->next_s());
    if (const auto firing = sonar_->fire(now_.pose)) firings_.push_back(*firing);
  }
  move_to(now_s);
}

RobotTruth SimulatedRobot::at(double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  move_on(now_s);
  return now_;
}

RobotState SimulatedRobot::read(double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  move_on(now_s);
  when_read_ = now_;
  return {now_.time_s, odometry_.pose(), odometry_.measure(now_.twist), now_.pan};
}

void SimulatedRobot::command(const Twist2& twist, double now_s) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (now_s > now_.time_s) move_on(now_s);
  body_->command(twist);
}

void SimulatedRobot::pan(double speed_radps, double now_s) {
  if (!pan_) return;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (now_s > now_.time_s) move_on(now_s);
  pan_->command(speed_radps);
}

void SimulatedRobot::put(const Pose2& pose) {
  const std::lock_guard<std::mutex> lock(mutex_);
  body_->put(pose);
  now_.pose = pose;
  odometry_.put(pose);
}

void SimulatedRobot::look_around() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (sonar_) sonar_->look_around();
}

void SimulatedRobot::listen(const std::function<void(const SonarReading&)>& hear) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (sonar_) sonar_->deliver(now_.time_s, hear);
}

}  // namespace ballservo
