#include "app/experiment/run_robot.hpp"

namespace ballservo {

namespace {

UnicycleLimits true_limits(const RobotSettings& robot) {
  UnicycleLimits limits = robot.limits;
  limits.a_max_mps2 *= robot.acceleration_share;
  limits.alpha_max_radps2 *= robot.acceleration_share;
  return limits;
}

}  // namespace

RunRobot::RunRobot(const Scenario& scenario, std::uint64_t seed)
    : drive_(scenario.robot.pose, true_limits(scenario.robot), scenario.robot.actuation_delay_s),
      odometry_(scenario.robot.odometry, scenario.robot.pose, seed) {
  if (scenario.robot.sonar) {
    sonar_.emplace(scenario.world, *scenario.robot.sonar, scenario.robot.sonar_faults, seed);
  }
}

void RunRobot::advance_to(double time_s) {
  drive_.advance_to(time_s);
  odometry_.move(drive_.pose());
}

double RunRobot::next_sonar_s() const {
  return sonar_ ? sonar_->next_s() : std::numeric_limits<double>::infinity();
}

void RunRobot::listen(const std::function<void(const SonarReading&)>& hear) {
  if (sonar_) sonar_->deliver(drive_.time_s(), hear);
}

}  // namespace ballservo
