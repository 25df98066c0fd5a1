// Obstacles that a trial's seed strews over the room.
#pragma once

#include <cstdint>

#include "calibration/files/strict_yaml.hpp"
#include "servo/simulation/world.hpp"
#include "servo/unicycle.hpp"

namespace ballservo {

/// Reads an item `{type: scatter, shape: box|cylinder|disc, count: [LOW, HIGH], ...}` of a scenario's
/// obstacles and adds what it stands for to the world: `item` is its number in the list. Nothing is put on
/// the robot's start, on a ball or its way, within `gap_m` of another obstacle or of a wall; what finds no
/// place in a hundred tries is left out. The same seed gives the same world.
void scatter_obstacles(YamlNode& node, std::size_t item, const Pose2& start, double duration_s,
                       std::uint64_t seed, World& world);

}  // namespace ballservo
