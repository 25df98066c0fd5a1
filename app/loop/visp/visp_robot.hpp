// A robot with two driven wheels that ViSP drives: vpSimulatorPioneer, or any vpRobot that takes (v, w).
//
// Needs ViSP's headers only where such a robot is made.
#pragma once

#include <functional>

#include "app/loop/ports.hpp"

class vpRobot;
class vpSimulatorPioneer;

namespace ballservo {

/// ViSP's simulators move on by their sampling time at each command: set it to the control period. They
/// follow a command at once: the controller's actuation_delay_s is then 0.
class VispRobot final : public Robot {
 public:
  /// X_OR, from the robot's own odometry.
  using Odometry = std::function<Pose2()>;

  /// Commands are limited to the limits, and ViSP's own are set to them: it prints wherever it saturates.
  /// Without odometry, the robot is taken to have done what it was told. `robot` must outlive it; it is told
  /// to stand still.
  VispRobot(vpRobot& robot, const UnicycleLimits& limits, Odometry odometry = {});

  RobotState read(double now_s) override;
  /// As vpRobot::setVelocity in the joints' frame; what that throws is handed on.
  void command(const Twist2& twist, double now_s) override;

 private:
  vpRobot& robot_;
  UnicycleLimits limits_;
  Odometry odometry_;
  RobotState state_;
  Twist2 followed_;
};

/// Where ViSP's simulated robot stands in its world, by its last command (its pose is that of the camera,
/// which vpUnicycle::set_cMe moves only with the next one).
Pose2 pose_of(const vpSimulatorPioneer& robot);

}  // namespace ballservo
