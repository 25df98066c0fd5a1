// The balls of a scenario, and how they move.
#pragma once

#include <cstdint>

#include "calibration/base/strict_yaml.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

/// What a ball's motion depends on besides its own keys.
struct BallContext {
  const World& world;  ///< the room, and what stands in it by name
  double duration_s = 0;
  std::uint64_t seed = 0;
  std::size_t index = 0;  ///< of the ball, in the list
};

/// Reads one item of `balls`. A ball shows the colour that its class is named for unless it says otherwise.
Ball read_ball(YamlNode& node, const BallContext& context);

}  // namespace ballservo
