// Where things probably stand, for finding ways: what the occupancy grid must not forget, this map may doubt.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "servo/avoidance/floor_scan.hpp"
#include "servo/avoidance/floor_window.hpp"
#include "servo/avoidance/occupancy_grid.hpp"
#include "servo/avoidance/sonar.hpp"

namespace ballservo {

/// The chance that something stands in each cell of a window of the floor around the robot, in the odometry's
/// frame. Cells are taken as independent: a firing that hears nothing short of r makes each cell of its cone
/// less likely; an echo at r says that at least one cell of its arc is occupied, and by Bayes' rule the cells
/// that the rest of the map explains least share that chance (Thrun, "Learning occupancy grid maps with
/// forward sensor models", Autonomous Robots 15, 2003, asks the same of whole maps). An arc whose cells other
/// firings have seen through thus shrinks to the thing that echoed. Nothing here is a matter of safety.
/// Allocates in the constructor only.
class ObstacleMap {
 public:
  static constexpr double cell_m = 0.06;
  static constexpr int size = 128;       ///< cells along each side: 7.68 m
  static constexpr float prior = 0.03f;  ///< of a cell of which nothing is known
  /// From here on a cell is taken as occupied.
  static constexpr float occupied = 0.3f;

  explicit ObstacleMap(const OccupancyGridOptions& options);

  /// The robot is there now: the window follows, and nothing stands where its body is.
  void move(const Pose2& pose);
  /// A firing, with the odometry's pose at that moment.
  void look(const SonarReading& reading, const Pose2& pose_then);
  /// A frame's word on the floor, with the odometry's pose when it was exposed.
  void look_at_floor(const FloorScan& scan, const Pose2& pose_then);

  /// The prior outside the window.
  float probability(const FloorCell& cell) const {
    return window_.contains(cell) ? probability_[window_.index(cell)] : prior;
  }
  static FloorCell cell_at(double x_m, double y_m) {
    return {floor_index(x_m, cell_m), floor_index(y_m, cell_m)};
  }
  static Eigen::Vector2d center_m(const FloorCell& cell) {
    return {(cell.column + 0.5) * cell_m, (cell.row + 0.5) * cell_m};
  }
  /// Squares of 2 x 2 cells, counted from the same origin; those that the window cuts are not occupied.
  static constexpr double block_m = 2 * cell_m;
  bool is_block_occupied(int column, int row) const {
    const FloorCell low{2 * column, 2 * row};
    if (!window_.contains(low) || !window_.contains({low.column + 1, low.row + 1})) return false;
    const float* const p =
        &probability_[window_.index(low)];  // an even cell and its neighbours lie side by side
    return p[0] >= occupied || p[1] >= occupied || p[size] >= occupied || p[size + 1] >= occupied;
  }
  /// Calls `visit` with each cell of the window that is taken as occupied.
  template <typename Visit>
  void visit_occupied(const Visit& visit) const {
    for (std::size_t k = 0; k < probability_.size(); ++k)
      if (probability_[k] >= occupied) visit(window_.cell(k));
  }
  /// The lower left cell of the window.
  const FloorCell& first() const { return window_.first(); }

 private:
  /// `arc_` holds the cells of which at least one is occupied, as an observation says that is right so often
  /// where it is so, and where it is not.
  void explain(float right, float wrong);

  OccupancyGridOptions options_;
  bool started_ = false;
  FloorWindow<size> window_;
  std::vector<float> probability_;
  std::vector<std::size_t> arc_;  // indices of cells
};

}  // namespace ballservo
