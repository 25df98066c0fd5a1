// Teaching by showing: the robot stands at the goal, looks, and remembers what it saw.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>

#include "app/experiment/runner.hpp"
#include "app/experiment/scenario.hpp"
#include "calibration/files/strict_yaml.hpp"

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

struct TeachOptions {
  PerceptionLevel perception = PerceptionLevel::image;
  std::uint64_t seed = 0;
  std::shared_ptr<const ColorTable> colors;  ///< for level image
  int frames = 60;                           ///< looked at; the tracker takes the first to confirm the ball
};

/// Puts the robot at the scenario's target distance from where the ball is at time 0, facing it, on the line
/// from its start, and looks; a ball that moves stands. Throws Refusal where something is in the way there,
/// or the ball is confirmed in less than half of the frames.
TaughtTarget teach_target(const Scenario& scenario, const TeachOptions& options);

/// The file that `target: {taught: FILE}` names; and back (InputError with every fault).
std::string taught_target_yaml(const TaughtTarget& target);
TaughtTarget read_taught_target(const std::filesystem::path& file);

}  // namespace ballservo
