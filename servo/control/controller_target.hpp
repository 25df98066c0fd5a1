// What the controller's files share: the ball as it will be when a command given now acts.
#pragma once

#include <Eigen/Core>

#include "servo/control/controller.hpp"

namespace ballservo {

inline constexpr double look_s = 0.4;  // standing still and looking, before a search begins to turn

struct Controller::Target {
  Eigen::Vector2d p_RB{0, 0}, v_RB{0, 0};        // in the floor plane, in the robot frame then
  Eigen::Vector3d p_CB{0, 0, 0}, v_CB{0, 0, 0};  // in the camera frame then
  double range_error_m = 0, bearing_rad = 0;
  RobotMotion robot;  // when the command acts
};

}  // namespace ballservo
