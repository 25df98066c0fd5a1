// What a scenario's parts must not do to each other.
#pragma once

#include "app/scenario/scenario.hpp"
#include "app/scenario/world_options.hpp"
#include "calibration/base/strict_yaml.hpp"

namespace ballservo {

/// Which parts outside the world were read without a fault.
struct ScenarioReading {
  bool robot_ok = false, mount_ok = false, camera_ok = false, target_ok = false;
};

/// Adds a fault for everything that stands in something else, lies outside the room or could not be seen at
/// the goal, as far as the parts concerned were read without a fault.
void check_scenario(StrictYaml& yaml, const Scenario& scenario, const WorldOptions& world,
                    const ScenarioReading& reading);

}  // namespace ballservo
