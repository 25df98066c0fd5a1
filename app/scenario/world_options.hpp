// The part of a scenario that describes the room and what stands, lies, moves and shines in it.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "app/scenario/scatter.hpp"
#include "calibration/base/options.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// What a scenario says of its world, which of it was read without a fault (so that the parts can be checked
/// against each other), and what chance has still to add.
struct WorldOptions {
  WorldOptions();

  World world;
  bool room_ok = false;
  std::vector<bool> ball_ok, obstacle_ok;
  std::vector<std::size_t> obstacle_item;  ///< of each obstacle: which item of the list it comes from

  std::vector<std::pair<std::size_t, CarriedWays>> carried;  ///< balls by index, and their ways
  std::vector<std::pair<std::size_t, Scatter>> scattered;    ///< items of the list of obstacles
};

/// `room`, `obstacles`, `balls`, `lights` and `light_level`, for a camera of that white balance and a run of
/// that length.
void declare(OptionVisitor& v, WorldOptions& options, double white_balance_k, double duration_s);

/// Draws the ways of carried balls, then what is scattered.
void draw_world(WorldOptions& options, const Pose2& start, double duration_s, std::uint64_t seed);

}  // namespace ballservo
