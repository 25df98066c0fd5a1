// The simulated robot of a run: its drive, what its odometry makes of the way, and its sonars.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "app/scenario/scenario.hpp"
#include "servo/simulation/robot/unicycle_robot.hpp"

namespace ballservo {

/// The robot at one instant.
struct RobotView {
  double time_s = 0;
  Pose2 pose;      ///< the true one
  Twist2 twist;    ///< the true one
  Pose2 odometry;  ///< what the robot believes
  Twist2 measured_twist;
};

class RunRobot {
 public:
  /// `scenario` must outlive the robot.
  RunRobot(const Scenario& scenario, std::uint64_t seed);

  void advance_to(double time_s);
  void command(const Twist2& twist) { drive_.command(twist); }

  double time_s() const { return drive_.time_s(); }
  const Pose2& pose() const { return drive_.pose(); }  ///< the true one
  RobotView view() const {
    return {time_s(), pose(), drive_.twist(), odometry_.pose(), odometry_.measure(drive_.twist())};
  }

  /// When the next sonar fires (s); never for a robot without sonars.
  double next_sonar_s() const;
  void fire_sonar() {
    if (const auto firing = sonar_->fire(drive_.pose())) firings_.push_back(*firing);
  }
  /// All that the sonars have said.
  const std::vector<SonarFiring>& firings() const { return firings_; }
  /// Hands over what has been heard by now.
  void listen(const std::function<void(const SonarReading&)>& hear);

 private:
  UnicycleRobot drive_;
  Odometry odometry_;
  std::optional<SonarRing> sonar_;
  std::vector<SonarFiring> firings_;
};

}  // namespace ballservo
