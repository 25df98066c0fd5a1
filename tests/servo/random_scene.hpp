// Seeded scenes for the servo side's tests.
#pragma once

#include <Eigen/Geometry>

#include "calibration/base/random.hpp"
#include "servo/control/law.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo::test {

/// A goal with a mount of any pitch up to 0.6 rad and any lever arm.
inline ServoGoal random_goal(RandomEngine& engine) {
  ServoGoal goal;
  goal.mount.forward_m = uniform(engine, -0.2, 0.3);
  goal.mount.up_m = uniform(engine, 0.1, 0.6);
  goal.mount.pitch_down_rad = uniform(engine, -0.2, 0.6);
  goal.distance_m = uniform(engine, 0.6, 2.0);
  goal.ball_height_m = uniform(engine, 0.03, 0.2);
  return goal;
}

/// A ball before the camera, as seen from a robot at the origin: range 0.4 to 6 m, bearing up to 50 degrees.
inline Eigen::Vector3d random_p_RB(RandomEngine& engine, const ServoGoal& goal) {
  const double range_m = uniform(engine, 0.6, 6.0), bearing_rad = uniform(engine, -0.9, 0.9);
  return {range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad), goal.ball_height_m};
}

inline Eigen::Vector3d in_camera(const ServoGoal& goal, const Pose2& pose, const Eigen::Vector3d& p_WB) {
  return (X_WR(pose) * goal.mount.X_RC()).inverse() * p_WB;
}

}  // namespace ballservo::test
