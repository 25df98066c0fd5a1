// Convex regions of the floor, and the cells of a grid that lie within them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "servo/avoidance/floor_window.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// Half planes (inside where n . p <= c) and, perhaps, a disc.
struct FloorRegion {
  /// The part of the region along a line of constant y; empty where low > high.
  struct Span {
    double low_m, high_m;
  };
  struct HalfPlane {
    double nx, ny, c;
  };
  std::array<HalfPlane, 4> planes;
  int plane_count = 0;
  double disc_x_m = 0, disc_y_m = 0, disc_radius_m = 0;  ///< no disc for 0
  double y_low_m = 0, y_high_m = 0;                      ///< bounds, not tight

  void add(double nx, double ny, double x, double y) {
    planes[static_cast<std::size_t>(plane_count++)] = {nx, ny, nx * x + ny * y};
  }
  Span at(double y_m) const;
  /// What lies within `margin_m` of the sides of the footprint at that pose.
  static FloorRegion around(const Footprint& footprint, const Pose2& pose, double margin_m);
  static FloorRegion disc(double x_m, double y_m, double radius_m);
  /// What lies before a transducer at that pose, within a radius and an angle to either side, both sides
  /// moved outwards.
  static FloorRegion cone(const Pose2& transducer, double half_angle_rad, double radius_m,
                          double outwards_m = 0);
};

/// Visits, row by row, the columns from the first to the last whose cells lie in the window and within the
/// region as a whole: a cell does exactly when its upper and its lower edge do.
template <int size, typename Visit>
void visit_cells_within(const FloorRegion& region, double cell_m, const FloorWindow<size>& window,
                        const Visit& visit) {
  const FloorCell corner = window.first();
  const int first = std::max(floor_index(region.y_low_m, cell_m), corner.row);
  const int last = std::min(floor_index(region.y_high_m, cell_m), corner.row + size - 1);
  FloorRegion::Span below = region.at(first * cell_m);
  for (int row = first; row <= last; ++row) {
    const FloorRegion::Span above = region.at((row + 1) * cell_m);
    const double low_m = std::max(below.low_m, above.low_m), high_m = std::min(below.high_m, above.high_m);
    const bool both = below.low_m <= below.high_m && above.low_m <= above.high_m && low_m < high_m;
    below = above;
    if (both)
      visit(row, std::max(static_cast<int>(std::ceil(low_m / cell_m)), corner.column),
            std::min(floor_index(high_m, cell_m), corner.column + size) - 1);
  }
}

}  // namespace ballservo
