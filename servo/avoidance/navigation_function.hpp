// Which way to go around what the sonars heard: the cost of the best way to the goal, from everywhere near.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "servo/avoidance/occupancy_grid.hpp"

namespace ballservo {

/// Cells waiting in order of their costs: a ring of buckets (Dial, CACM 12, 1969), each a doubly linked list.
/// All costs that wait at once lie within the ring's length of each other. Obstacles.yaml spends 145 us (p99)
/// in a control step with it, 312 us with a binary heap.
class BucketQueue {
 public:
  static constexpr std::int32_t nobody = -1;

  explicit BucketQueue(std::size_t cells) : next_(cells, nobody), before_(cells, nobody) { clear(); }
  void clear() {
    bucket_.fill(nobody);
    waiting_ = 0;
  }
  bool empty() const { return waiting_ == 0; }
  /// A cell that waits at that cost, or in a later round of the ring; `nobody` where there is none.
  std::int32_t first_at(std::int32_t cost) const { return bucket_[bucket_of(cost)]; }
  void put(std::size_t cell, std::int32_t cost);
  void take(std::size_t cell, std::int32_t cost);

 private:
  static std::size_t bucket_of(std::int32_t cost) { return static_cast<std::size_t>(cost) % 1024; }
  std::vector<std::int32_t> next_, before_;  // of each cell, in its bucket
  std::array<std::int32_t, 1024> bucket_;    // the first of each
  int waiting_ = 0;
};

/// A navigation function on blocks of the occupancy grid's window (Konolige, "A gradient method for realtime
/// robot control", IROS 2000): costs of ways by Dijkstra's algorithm from every place at the desired distance
/// from the ball that sees it. What is unknown may be driven through: the shield knows better. Allocates in
/// the constructor only.
class NavigationFunction {
 public:
  static constexpr double block_m = OccupancyGrid::block * OccupancyGrid::cell_m;
  static constexpr int size = OccupancyGrid::size / OccupancyGrid::block;

  /// With less clearance than this (m) a way costs much more than on open floor.
  static constexpr double narrow_m = 0.38;

  NavigationFunction();

  /// Looks anew at what is suspected where; the costs are computed when they are asked for.
  void update(const OccupancyGrid& grid, const Eigen::Vector2d& p_OB, double distance_m, double ball_gap_m,
              double now_s);

  /// Puts something where the robot could not pass though nothing was heard there; forgotten after a while.
  void add_virtual(double x_m, double y_m, double now_s);

  /// Cost (m) of the best way from a place; infinite where there is none or the field does not reach.
  double cost_at(const Eigen::Vector2d& p_O);
  /// Distance (m) from a place to the nearest thing suspected, at most about a metre.
  double clearance_at(const Eigen::Vector2d& p_O) const;
  /// Whether the robot can go straight from one place to the other.
  bool straight(const Eigen::Vector2d& from_O, const Eigen::Vector2d& to_O) const;

  /// The heading (rad, in the odometry's frame) that leads to the ball soonest, among headings that keep the
  /// ball at `ball_heading_rad` within `half_view_rad` if that costs little. Nothing where there is no way.
  std::optional<double> heading(const Pose2& pose, double ball_heading_rad, double half_view_rad);

 private:
  struct Virtual {
    double x_m = 0, y_m = 0, until_s = -1e9;
  };
  bool block_of(const Eigen::Vector2d& p, int& column, int& row) const;
  Eigen::Vector2d center(int column, int row) const {
    return {(first_column_ + column + 0.5) * block_m, (first_row_ + row + 0.5) * block_m};
  }
  static std::size_t index(int column, int row) {
    return static_cast<std::size_t>(row) * size + static_cast<std::size_t>(column);
  }
  void measure_clearance(const OccupancyGrid& grid, const Eigen::Vector2d& p_OB, double ball_gap_m,
                         double now_s);
  void spread_clearance(int step);
  bool sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  void find_ways();
  void seed(const Eigen::Vector2d& p_OB, double distance_m);
  void spread(const Eigen::Vector2d& p_OR);
  void put(std::size_t cell, std::int32_t cost) {
    cost_[cell] = cost;
    queue_.put(cell, cost);
  }

  int first_column_ = 0, first_row_ = 0;
  std::vector<float> clearance_m_;  // m
  std::vector<std::int32_t> cost_;  // in quanta; `none` where unknown
  BucketQueue queue_;
  bool ways_known_ = false;
  Eigen::Vector2d p_OB_{0, 0}, p_OR_{0, 0};
  double distance_m_ = 0;
  std::array<Virtual, 8> virtual_{};
  std::size_t next_virtual_ = 0;
};

}  // namespace ballservo
