// A ball that is carried about: its ways, drawn by the seed.
#pragma once

#include <vector>

#include "app/scenario/drawn_range.hpp"
#include "calibration/base/random.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

struct CarriedWays {
  double speed_mps = 0.2;  ///< up, along and down
  double height_m = 0;     ///< by which it is lifted
  DrawnRange rest_s;       ///< before each way
  DrawnRange x_m, y_m;     ///< where it is put down (world)
  double end_s = 0;        ///< by which it lies for good
};

/// It rests, is lifted, carried straight to a place drawn anew and put down, again and again while there is
/// time for a whole way. A way keeps 5 cm from the circles around what stands there; where none of a hundred
/// places drawn can be reached so, the ball stays.
WaypointMotion carry(const Ball& ball, const CarriedWays& ways, const std::vector<Obstacle>& obstacles,
                     RandomEngine& engine);

}  // namespace ballservo
