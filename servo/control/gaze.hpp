// Where the camera looks, on a mount with a pan: at the ball, whatever the drive does.
#pragma once

#include <Eigen/Core>

#include "servo/motion/camera_mount.hpp"
#include "servo/motion/motion_history.hpp"

namespace ballservo {

/// The third degree of freedom of the servo task. The laws' two features are of the camera looking straight
/// ahead, which a pan does not move: it lies in the null space of their task, so that a task of its own takes
/// nothing from theirs. Its feature is the ball's azimuth in the turned camera (ConeFeature's second).
/// Desired is the value within [-aside_max_rad, aside_max_rad] that lets the camera look ahead as far as it
/// can, for there the robot drives: it looks straight ahead while the ball is well inside the picture. With
/// the azimuth a of the ball as seen from the camera, straight ahead 0, and the pan q,
///
///     e = a - a* - q,    e' = a'(v, w, ball) - q',    so that    q' = lambda e + a'
///
/// lets e decay at lambda. Before its stops the pan brakes, and looks as far aside as it can.
///
/// All speeds are in rad/s, left positive, within the limits, for a pan that stands and turns as `now` says;
/// 0 for a mount without a pan. Call one of the three a control step; times rise.
class Gaze {
 public:
  /// `history`: commands that are remembered over the delay.
  Gaze(const CameraMount& mount, double aside_max_rad, double actuation_delay_s, std::size_t history);

  /// The ball in the floor plane when a command given now acts, in the robot frame then (m, m/s over ground).
  struct Target {
    Eigen::Vector2d p_RB{0, 0}, v_RB{0, 0};
  };
  /// To the ball, on a robot that moves at `twist` when the command acts.
  double follow(double time_s, const PanMotion& now, const Target& target, const Twist2& twist);
  /// From one stop to the other and back.
  double scan(double time_s, const PanMotion& now);
  /// To one side as far as it goes: 1 left, -1 right, 0 straight ahead.
  double look_aside(double side, double time_s, const PanMotion& now);

 private:
  struct Aim {
    double angle_rad = 0, speed_radps = 0, closing_max_radps = 100;
  };
  double turn_to(const Aim& aim, double time_s, const PanMotion& now);

  CameraMount mount_;
  double aside_max_rad_;
  MotionPredictor predictor_;  // of a drive that turns on the spot
  double side_ = 1;            // that is scanned
};

}  // namespace ballservo
