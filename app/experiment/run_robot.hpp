// The simulated robot of a run: its drive, what its odometry makes of the way, and its sonars.
#pragma once

#include <limits>
#include <optional>

#include "app/experiment/scenario.hpp"
#include "servo/simulation/unicycle_robot.hpp"

namespace ballservo {

class RunRobot {
 public:
  /// `scenario` must outlive the robot.
  RunRobot(const Scenario& scenario, std::uint64_t seed);

  void advance_to(double time_s);
  void command(const Twist2& twist) { drive_.command(twist); }

  double time_s() const { return drive_.time_s(); }
  const Pose2& pose() const { return drive_.pose(); }     ///< the true one
  const Twist2& twist() const { return drive_.twist(); }  ///< the true one

  /// What the robot believes.
  const Pose2& odometry() const { return odometry_.pose(); }
  Twist2 measured_twist() const { return odometry_.measure(drive_.twist()); }

  /// When the next sonar fires (s); never for a robot without sonars.
  double next_sonar_s() const;
  void fire_sonar() { sonar_->fire(drive_.pose()); }
  /// Hands over what has been heard by now.
  void listen(const std::function<void(const SonarReading&)>& hear);

 private:
  UnicycleRobot drive_;
  Odometry odometry_;
  std::optional<SonarRing> sonar_;
};

}  // namespace ballservo
