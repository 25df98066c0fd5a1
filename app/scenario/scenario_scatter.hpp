// Obstacles and look-alike balls that a trial's seed strews over the room.
#pragma once

#include <cstdint>

#include "calibration/base/strict_yaml.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// What the strewn part of a world depends on.
struct ScatterContext {
  Pose2 start;  ///< of the robot
  double duration_s = 0;
  std::uint64_t seed = 0;
};

/// Reads an item `{type: scatter, shape: box|cylinder|disc|ball, count: [LOW, HIGH], ...}` of a scenario's
/// obstacles and adds what it stands for to the world: `item` is its number in the list. A ball is of the
/// class that its colour is named for and lies still. Nothing is put on the robot's start, on a ball or its
/// way, within `gap_m` of another obstacle or of a wall; what finds no place in a hundred tries is left out.
/// The same seed gives the same world.
void scatter_things(YamlNode& node, std::size_t item, const ScatterContext& context, World& world);

}  // namespace ballservo
