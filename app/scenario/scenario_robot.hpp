// The part of a scenario that describes the robot: where it starts, its drive, odometry and sonars, and what
// is wrong with them.
#pragma once

#include "app/scenario/scenario.hpp"
#include "calibration/base/strict_yaml.hpp"

namespace ballservo {

/// Reads `robot` below the root. Returns whether it was read without a fault; faults go to the document's
/// list.
bool read_robot(StrictYaml& yaml, RobotSettings& robot);

/// Reads `avoidance` below the root, for a robot that was read before: `full` for one with sonars, `none` for
/// one without, unless the scenario says otherwise.
AvoidanceOptions read_avoidance(StrictYaml& yaml, const RobotSettings& robot);

}  // namespace ballservo
