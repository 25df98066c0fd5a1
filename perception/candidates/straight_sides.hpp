// The straight sides of a region's outline. No ball has any, but the circles that fit into a box or between
// two things do: what lies on a straight side need not be asked for circles.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calibration/circles/circle_vote.hpp"

namespace ballservo {

/// Finds straight sides; keeps its buffers between calls.
class StraightSides {
 public:
  /// Whether each point lies on a straight side. `points` follow each other along the outlines (see
  /// BoundaryChain), where undistorted lines are straight. A side is so long that an arc of a circle as large
  /// as the whole outline would bend by more than the points scatter: of a smaller one the more.
  const std::vector<char>& find(const std::vector<BoundaryPoint>& points);

 private:
  // Of all points before one: their number is its index.
  struct Sums {
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  };
  bool is_straight(std::size_t begin, std::size_t end) const;

  std::vector<Sums> sums_;
  std::vector<double> path_px_;  // along the outline to each point
  std::vector<char> straight_;
};

}  // namespace ballservo
