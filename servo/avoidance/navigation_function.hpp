// How much room there is around the robot, and what it costs to get to the goal from everywhere near.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "servo/avoidance/obstacle_map.hpp"

namespace ballservo {

/// Cells waiting in order of their costs: a ring of buckets (Dial, CACM 12, 1969). All costs that wait at
/// once lie within the ring's length of each other. A cell whose cost falls is put again; whoever takes it at
/// its old cost passes it over. Allocates in the constructor only.
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

/// A navigation function on blocks of the obstacle map's window (Konolige, "A gradient method for realtime
/// robot control", IROS 2000): costs of ways by Dijkstra's algorithm from every place at the desired distance
/// from the ball that sees it, for a robot that can turn anywhere. Costs are metres on open floor. What is
/// unknown may be driven through: the shield knows better. Allocates in the constructor only.
class NavigationFunction {
 public:
  static constexpr double block_m = 2 * ObstacleMap::cell_m;
  static constexpr int size = ObstacleMap::size / 2;  ///< blocks along each side

  explicit NavigationFunction(const Footprint& footprint);

  /// Looks anew at what stands where, and at what the shield knows to be free; the costs are computed when
  /// they are asked for, as far as the robot. What stands within `ball_gap_m` of the ball is the ball.
  void update(const ObstacleMap& map, const OccupancyGrid& grid, const Eigen::Vector2d& p_OR,
              const Eigen::Vector2d& p_OB, double distance_m, double ball_gap_m);

  static constexpr float far_m = 1.2f;  ///< distances are measured up to this
  /// From a place to the nearest thing (m).
  double clearance_m(const Eigen::Vector2d& p_O) const { return at(clearance_m_, p_O); }
  /// From the body to the nearest thing (m), to half a cell; negative where they overlap. Three discs stand
  /// for the body.
  double gap_m(const Pose2& pose) const { return from_body_m(clearance_m_, discs_at(pose)); }
  /// How many times as much as on open floor a way costs there; infinite where the body does not fit.
  double price(const Pose2& pose) const {
    const Discs discs = discs_at(pose);
    return price(from_body_m(clearance_m_, discs), from_body_m(sure_m_, discs));
  }
  /// Whether the robot can go straight from one place to the other with that gap.
  bool straight(const Eigen::Vector2d& from_O, const Eigen::Vector2d& to_O, double gap_m) const;

  /// A block of the window; `inside` is false beyond it.
  using Block = FloorCell;
  Block block_at(const Eigen::Vector2d& p_O) const {
    return {floor_index(p_O.x(), block_m) - first_.column / 2,
            floor_index(p_O.y(), block_m) - first_.row / 2};
  }
  static bool inside(const Block& block) {
    return block.column >= 0 && block.row >= 0 && block.column < size && block.row < size;
  }
  Eigen::Vector2d center_m(const Block& block) const {
    return {(first_.column / 2 + block.column + 0.5) * block_m, (first_.row / 2 + block.row + 0.5) * block_m};
  }
  static std::size_t index(const Block& block) {
    return static_cast<std::size_t>(block.row) * size + static_cast<std::size_t>(block.column);
  }

  /// Nothing stands on the line from the middle of a block to the ball; remembered until the next update.
  bool sees_ball(const Block& block);
  /// Cost of the best way from there; infinite where there is none.
  double cost_m(const Block& block);
  /// Whether ways end there.
  bool is_goal(const Block& block) const { return goal_[index(block)] != 0; }

 private:
  bool is_ball(const FloorCell& cell) const;
  void measure_clearance(const ObstacleMap& map);
  void measure_sure(const OccupancyGrid& grid);
  static void spread_clearance(std::vector<float>& field_m);
  static std::size_t cell_index(int column, int row) {
    return static_cast<std::size_t>(row) * ObstacleMap::size + static_cast<std::size_t>(column);
  }
  double at(const std::vector<float>& field_m, const Eigen::Vector2d& p_O) const {
    const FloorCell cell = ObstacleMap::cell_at(p_O.x(), p_O.y());
    const int column = cell.column - first_.column, row = cell.row - first_.row;
    if (column < 0 || row < 0 || column >= ObstacleMap::size || row >= ObstacleMap::size) return far_m;
    return field_m[cell_index(column, row)];
  }
  using Discs = std::array<Eigen::Vector2d, 3>;  // centres of those that stand for the body
  Discs discs_at(const Pose2& pose) const;
  double from_body_m(const std::vector<float>& field_m, const Discs& discs) const;
  /// `sure_m`: the gap to what the shield does not know to be free.
  static double price(double gap_m, double sure_m);
  void find_ways();
  double price_of(const Block& block);
  void seed();
  void spread();
  void put(std::size_t cell, std::int32_t cost) {
    cost_[cell] = cost;
    queue_.put(static_cast<std::int32_t>(cell), cost);
  }

  double half_width_m_, disc_radius_m_;
  std::array<double, 3> disc_x_m_;           // centres of the body's discs, ahead of the axle
  FloorCell first_;                          // of the window; even
  std::vector<float> clearance_m_, sure_m_;  // of the map's cells: to what stands, to what is not free
  std::vector<std::int32_t> cost_;           // of blocks, in quanta; `none` where unknown
  std::vector<double> price_;                // of blocks; 0 where it was not asked for yet
  std::vector<std::uint8_t> goal_;
  enum class Sight : std::uint8_t { unknown, free, hidden };
  std::vector<Sight> sight_;  // of blocks
  BucketQueue queue_;
  bool ways_known_ = false;
  Eigen::Vector2d p_OR_{0, 0}, p_OB_{0, 0};
  double distance_m_ = 0, ball_gap_m_ = 0;
};

}  // namespace ballservo
