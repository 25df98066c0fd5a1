#include "app/loop/visp/visp_robot.hpp"

#include <visp3/robot/vpRobot.h>
#include <visp3/robot/vpSimulatorPioneer.h>

#include <cmath>
#include <utility>

#include "calibration/base/options.hpp"

namespace ballservo {

VispRobot::VispRobot(vpRobot& robot, const UnicycleLimits& limits, Odometry odometry)
    : robot_(robot), limits_(limits), odometry_(std::move(odometry)) {
  check_options("limits", limits);
  // A little more, for what rounding makes of a command at the limit.
  robot.setMaxTranslationVelocity(1.001 * limits.v_max_mps);
  robot.setMaxRotationVelocity(1.001 * limits.w_max_radps);
  robot.setRobotState(vpRobot::STATE_VELOCITY_CONTROL);
  command({}, 0);
  if (odometry_) state_.odometry = odometry_();
}

RobotState VispRobot::read(double now_s) {
  const double passed_s = now_s - state_.time_s;
  if (!(passed_s > 0)) return state_;
  if (odometry_) {
    const Pose2 before = std::exchange(state_.odometry, odometry_());
    const Pose2& now = state_.odometry;
    const Eigen::Vector2d way = in_robot_frame(before, {now.x_m, now.y_m});
    state_.twist = {way.x() / passed_s, wrap_angle(now.yaw_rad - before.yaw_rad) / passed_s};
  } else {
    state_.odometry = integrate(state_.odometry, followed_, passed_s);
    state_.twist = followed_;
  }
  state_.time_s = now_s;
  return state_;
}

void VispRobot::command(const Twist2& twist, double now_s) {
  (void)now_s;
  followed_ = limit_speed(twist, limits_);
  vpColVector velocity(2);
  velocity[0] = followed_.v_mps;
  velocity[1] = followed_.w_radps;
  robot_.setVelocity(vpRobot::ARTICULAR_FRAME, velocity);
}

Pose2 pose_of(const vpSimulatorPioneer& robot) {
  vpHomogeneousMatrix wMc;
  robot.getPosition(wMc);
  const vpHomogeneousMatrix wMe = wMc * robot.get_cMe();
  return {wMe[0][3], wMe[1][3], std::atan2(wMe[1][0], wMe[0][0])};
}

}  // namespace ballservo
