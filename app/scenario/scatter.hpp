// What a seed draws of a world: obstacles and look-alike balls strewn over the room, and the ways of a ball
// that is carried about.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/base/options.hpp"
#include "calibration/base/random.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

struct DrawnRange {
  double low = 0, high = 0;
  double draw(RandomEngine& engine) const { return uniform(engine, low, high); }
};

/// Bounds in falling order are a fault.
inline void declare_range(OptionVisitor& v, const std::string& key, DrawnRange& range,
                          const NumberRange& allowed, const std::string& help,
                          const Fallback& fallback = {}) {
  std::vector<double> bounds{range.low, range.high};
  v.numbers(key, bounds, allowed, 2, help, fallback);
  v.require(bounds[0] <= bounds[1], key, "bounds in falling order", "[low, high]");
  range = {bounds[0], bounds[1]};
}

/// An item `{type: scatter, shape: box|cylinder|disc|ball, count: [LOW, HIGH], ...}` of a scenario's
/// obstacles.
struct Scatter {
  std::string shape, name;
  DrawnRange count{1, 1}, size_m{0.2, 0.6}, height_m{0.3, 1.0}, bottom_m{0, 0};
  DrawnRange x_m, y_m;  ///< of the centres (world)
  double gap_m = 0.1, start_gap_m = 0.75, ball_gap_m = 0.2;
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
