// What a robot that was taught by showing remembers, and its file.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

namespace ballservo {

/// What the robot saw of a ball at the goal.
struct TaughtTarget {
  std::string ball;  ///< its name in the scenario
  /// C/R: the ball's centre in the camera frame in units of its radius. A function of the image and the
  /// camera's calibration alone: whatever diameter was believed, it is the same.
  Eigen::Vector3d center_over_radius{0, 0, 0};
  Eigen::Vector3d sigma{0, 0, 0};  ///< of each, from the scatter of the frames
  int frames = 0;                  ///< in which the ball was confirmed
  double distance_m = 0;           ///< axle to the ball's centre as it stood: what errors are counted from
};

/// The file that `target: {taught: FILE}` names; and back (InputError with every fault).
std::string taught_target_yaml(const TaughtTarget& target);
TaughtTarget read_taught_target(const std::filesystem::path& file);

}  // namespace ballservo
