// Which way to go around what the sonars heard: the cost of the best way to the goal, from everywhere near.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "servo/avoidance/occupancy_grid.hpp"

namespace ballservo {

/// Cells waiting in order of their costs: a ring of buckets (Dial, CACM 12, 1969). All costs that wait at
/// once lie within the ring's length of each other. A cell whose cost falls is put again; whoever takes it at
/// its old cost passes it over. Obstacles.yaml spends 145 us (p99) in a control step with it, 312 us with a
/// binary heap. Allocates in the constructor only.
class BucketQueue {
 public:
  explicit BucketQueue(std::size_t most_puts) {
    entries_.reserve(most_puts);
    clear();
  }
  void clear() {
    entries_.clear();
    first_.fill(none);
    waiting_ = 0;
  }
  bool empty() const { return waiting_ == 0; }
  void put(std::int32_t cell, std::int32_t cost) {
    std::int32_t& first = first_[static_cast<std::size_t>(cost) % first_.size()];
    entries_.push_back({cell, first});
    first = static_cast<std::int32_t>(entries_.size()) - 1;
    ++waiting_;
  }
  /// A cell that waits at that cost; nothing where there is none.
  std::optional<std::int32_t> take(std::int32_t cost) {
    std::int32_t& first = first_[static_cast<std::size_t>(cost) % first_.size()];
    if (first == none) return std::nullopt;
    const Entry entry = entries_[static_cast<std::size_t>(first)];
    first = entry.next;
    --waiting_;
    return entry.cell;
  }

 private:
  static constexpr std::int32_t none = -1;
  struct Entry {
    std::int32_t cell, next;
  };
  std::vector<Entry> entries_;
  std::array<std::int32_t, 1024> first_;  // of each bucket
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

  /// The same for ways from the robot to everywhere.
  void update_from_robot(const OccupancyGrid& grid, double now_s);

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
  void follow(const Pose2& pose);
  void measure_clearance(const OccupancyGrid& grid, const Eigen::Vector2d& p_OB, double ball_gap_m,
                         double now_s);
  void spread_clearance(int step);
  bool sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  void find_ways();
  void seed(const Eigen::Vector2d& p_OB, double distance_m);
  void spread(const Eigen::Vector2d& p_OR, double beyond_m);
  void put(std::size_t cell, std::int32_t cost) {
    cost_[cell] = cost;
    queue_.put(static_cast<std::int32_t>(cell), cost);
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
