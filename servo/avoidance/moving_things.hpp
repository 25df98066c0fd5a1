// Where things that move may be by now: everywhere that the sonars have not shown to be free of them.
#pragma once

#include <array>
#include <cstdint>

#include "servo/avoidance/floor_region.hpp"
#include "servo/avoidance/floor_window.hpp"
#include "servo/avoidance/occupancy_grid.hpp"
#include "servo/avoidance/sonar.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

struct MovingThingOptions {
  double speed_mps = 0;    ///< nothing moves faster; 0: nothing moves
  double radius_m = 0.20;  ///< a disc so large fits into everything that moves
};
void declare(OptionVisitor& v, MovingThingOptions& moving);

/// The places where the middle of a moving disc may be: all that no firing has shown to be free, grown by the
/// speed of things, less what each firing shows. It is the set that they can reach unseen (Bouraine,
/// Fraichard and Salhi, "Provably safe navigation for mobile robots with limited field-of-views in dynamic
/// environments", Autonomous Robots 32, 2012), in a window of square cells around the robot, in the
/// odometry's frame; outside of it they may be anywhere. Things that rest belong to it as well. Allocates
/// nothing.
class MovingThings {
 public:
  static constexpr double cell_m = OccupancyGrid::cell_m;
  static constexpr int size = OccupancyGrid::size;

  MovingThings(const MovingThingOptions& options, const OccupancyGridOptions& grid);

  /// The robot is there now; times must not run backwards. The first call is the start.
  void move(double time_s, const Pose2& pose);
  /// A firing, with the odometry's pose at that moment.
  void look(const SonarReading& reading, const Pose2& pose_then);

  /// Whether one may come within `margin_m` of the footprint, at that pose so much later.
  bool may_touch(const Footprint& footprint, const Pose2& pose, double margin_m, double later_s) const;

 private:
  using Row = std::array<std::uint64_t, size / 64>;  // a bit a cell: a middle may be there

  void exclude(const FloorRegion& region);
  void grow();

  MovingThingOptions options_;
  OccupancyGridOptions grid_;
  FloorWindow<size> window_;
  std::array<Row, size> rows_;  // a ring, as are the columns of each
  bool started_ = false;
  double time_s_ = 0, grown_m_ = 0;  // grown since the cells did
  Pose2 pose_;
  std::array<double, sonar_count> last_range_m_{};
};

}  // namespace ballservo
