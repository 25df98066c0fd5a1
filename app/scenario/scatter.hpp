// Obstacles and look-alike balls that a trial's seed strews over the room.
#pragma once

#include <cstdint>
#include <string>

#include "app/scenario/drawn_range.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// An item `{type: scatter, shape: box|cylinder|disc|ball, count: [LOW, HIGH], ...}` of a scenario's
/// obstacles.
struct Scatter {
  std::string shape, name;
  DrawnRange count{1, 1}, size_m{0.2, 0.6}, height_m{0.3, 1.0}, bottom_m{0, 0};
  DrawnRange x_m, y_m;  ///< of the centres (world)
  double gap_m = 0.1, start_gap_m = 0.6, ball_gap_m = 0.2;
  std::string color = "any";
};
void declare(OptionVisitor& v, Scatter& scatter);

/// What the strewn part of a world depends on.
struct ScatterContext {
  Pose2 start;  ///< of the robot
  double duration_s = 0;
  std::uint64_t seed = 0;
};

/// Adds what `scatter`, the `item`-th of the list, stands for to the world. A ball is of the class that its
/// colour is named for and lies still. Nothing is put on the robot's start, on a ball or its way, within
/// `gap_m` of another obstacle or of a wall; what finds no place in a hundred tries is left out. The same
/// seed gives the same world.
void scatter_things(const Scatter& scatter, std::size_t item, const ScatterContext& context, World& world);

}  // namespace ballservo
