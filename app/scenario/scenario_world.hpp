// The part of a scenario that describes the room and what stands, lies and moves in it.
#pragma once

#include <vector>

#include "app/scenario/scenario_scatter.hpp"
#include "calibration/base/strict_yaml.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// A world, and which of its parts were read without a fault, so that they can be checked against each other.
struct WorldReading {
  World world;
  bool room_ok = false;
  std::vector<bool> ball_ok, obstacle_ok;
  std::vector<std::size_t> obstacle_item;  ///< of each obstacle: which item of the list it comes from
};

/// Reads `room`, `balls`, `obstacles`, `lights` and `light_level` below the root. Faults go to the document's
/// list.
WorldReading read_world(StrictYaml& yaml, const ScatterContext& context);

}  // namespace ballservo
