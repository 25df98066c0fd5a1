#include "servo/avoidance/navigation_function.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {

namespace {

constexpr int cells = ObstacleMap::size;
constexpr double quantum_m = 0.01;
constexpr std::int32_t none = std::numeric_limits<std::int32_t>::max();

// Gaps beside the body, and how many times as much as on open floor a metre costs there.
constexpr double no_gap_m = 0.04;     // nearer the robot does not go by intent: half a cell of the map
constexpr double tight_gap_m = 0.18;  // here the shield begins to have its doubts
constexpr double wide_gap_m = 0.50;   // from here on the floor is open
constexpr double goal_gap_m = 0.10;   // nearer to something no way ends
constexpr double goal_price_m = 1.5;  // for each part that a metre costs more at a goal
constexpr double tight_price = 3.0, no_price = 20.0;

// The same to what the shield does not know to be free, near the robot: further off nothing was seen yet.
constexpr double near_m = 1.2, unsure_gap_m = 0.03, sure_gap_m = 0.12, unsure_price = 6.0;

/// From a block to one beside it.
struct Step {
  int columns, rows;
  double length_m = (columns != 0 && rows != 0 ? 1.4142135623730951 : 1.0) * NavigationFunction::block_m;
  std::int32_t least_cost = static_cast<std::int32_t>(length_m / quantum_m);  // no price is below 1
};
constexpr Step steps[] = {{-1, -1}, {0, -1}, {1, -1}, {-1, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}};

/// From `low` to `high` as x goes from a to b.
double between(double x, double a, double b, double low, double high) {
  return low + (high - low) * std::clamp((x - a) / (b - a), 0.0, 1.0);
}

}  // namespace

NavigationFunction::NavigationFunction(const Footprint& footprint)
    : half_width_m_(footprint.half_width_m),
      clearance_m_(FloorWindow<ObstacleMap::size>::cells, far_m),
      sure_m_(clearance_m_),
      cost_(static_cast<std::size_t>(size) * size, none),
      price_(cost_.size(), 0),
      goal_(cost_.size(), 0),
      sight_(goal_.size(), Sight::unknown),
      queue_(static_cast<std::size_t>(9 * size) * size) {  // a block may start, and eight neighbours lower it
  const double third_m = (footprint.front_m + footprint.rear_m) / 3.0;
  disc_radius_m_ = std::hypot(0.5 * third_m, footprint.half_width_m);
  for (std::size_t k = 0; k < disc_x_m_.size(); ++k) {
    disc_x_m_[k] = -footprint.rear_m + (static_cast<double>(k) + 0.5) * third_m;
  }
}

NavigationFunction::Discs NavigationFunction::discs_at(const Pose2& pose) const {
  const Eigen::Vector2d p(pose.x_m, pose.y_m), ahead(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  return {p + disc_x_m_[0] * ahead, p + disc_x_m_[1] * ahead, p + disc_x_m_[2] * ahead};
}

double NavigationFunction::from_body_m(const std::vector<float>& field_m, const Discs& discs) const {
  double least_m = far_m;
  for (const Eigen::Vector2d& center : discs) least_m = std::min(least_m, at(field_m, center));
  return least_m - disc_radius_m_;
}

double NavigationFunction::price(double gap_m, double sure_m) {
  if (gap_m < no_gap_m) return std::numeric_limits<double>::infinity();
  const double narrow = gap_m < tight_gap_m ? between(gap_m, no_gap_m, tight_gap_m, no_price, tight_price)
                                            : between(gap_m, tight_gap_m, wide_gap_m, tight_price, 1.0);
  return std::max(narrow, between(sure_m, unsure_gap_m, sure_gap_m, unsure_price, 1.0));
}

bool NavigationFunction::is_ball(const FloorCell& cell) const {
  return (ObstacleMap::center_m(cell) - p_OB_).squaredNorm() <= ball_gap_m_ * ball_gap_m_;
}

void NavigationFunction::measure_clearance(const ObstacleMap& map) {
  std::fill(clearance_m_.begin(), clearance_m_.end(), far_m);
  map.visit_occupied([this](const FloorCell& cell) {
    const int column = cell.column - first_.column, row = cell.row - first_.row;
    if (column < cells && row < cells && !is_ball(cell)) clearance_m_[cell_index(column, row)] = 0.0f;
  });
  spread_clearance(clearance_m_);
}

void NavigationFunction::measure_sure(const OccupancyGrid& grid) {
  std::fill(sure_m_.begin(), sure_m_.end(), far_m);
  const Eigen::Vector2d p_OR(grid.pose().x_m, grid.pose().y_m), reach_m(near_m, near_m);
  grid.visit_not_free(
      p_OR - reach_m, p_OR + reach_m, OccupancyGrid::Drift::close, [&](const FloorCell& part) {
        const FloorCell cell{part.column >> 1, part.row >> 1};  // of the map: 2 x 2 of the grid's
        const int column = cell.column - first_.column, row = cell.row - first_.row;
        const Eigen::Vector2d from_robot_m = ObstacleMap::center_m(cell) - p_OR;
        if (column >= 0 && row >= 0 && column < cells && row < cells && !is_ball(cell) &&
            from_robot_m.cwiseAbs().maxCoeff() < near_m)
          sure_m_[cell_index(column, row)] = 0.0f;
      });
  spread_clearance(sure_m_);
}

/// A chamfer distance transform (Borgefors, CVGIP 34, 1986), down and up: what lies in the rows before, row
/// by row; then what lies beside in the row, several rows at once, as each cell waits for the one before it.
void NavigationFunction::spread_clearance(std::vector<float>& field_m) {
  constexpr float side = static_cast<float>(ObstacleMap::cell_m), diagonal = 1.4142135f * side;
  constexpr int together = 8;
  static_assert(cells % together == 0);
  for (const int step : {+1, -1}) {
    const int begin = step > 0 ? 0 : cells - 1;
    for (int k = 1; k < cells; ++k) {
      float* const row = &field_m[cell_index(0, begin + k * step)];
      const float* const before = row - step * cells;
      for (int c = 0; c < cells; ++c) row[c] = std::min(row[c], before[c] + side);
      for (int c = 1; c < cells; ++c) row[c] = std::min(row[c], before[c - 1] + diagonal);
      for (int c = 0; c + 1 < cells; ++c) row[c] = std::min(row[c], before[c + 1] + diagonal);
    }
    for (int first = 0; first < cells; first += together) {
      for (int k = 1; k < cells; ++k) {
        float* const column = &field_m[cell_index(begin + k * step, first)];
        for (int r = 0; r < together; ++r)
          column[r * cells] = std::min(column[r * cells], column[r * cells - step] + side);
      }
    }
  }
}

bool NavigationFunction::sees_ball(const Block& block) {
  if (!inside(block)) return false;
  Sight& sight = sight_[index(block)];
  if (sight == Sight::unknown) {
    sight = Sight::free;
    const Eigen::Vector2d p_O = center_m(block), way = p_OB_ - p_O;
    const double length_m = way.norm();
    for (double s_m = 0; s_m < length_m - 0.25; s_m += ObstacleMap::cell_m) {
      if (clearance_m(p_O + way * (s_m / length_m)) >= 0.5 * ObstacleMap::cell_m) continue;
      sight = Sight::hidden;
      break;
    }
  }
  return sight == Sight::free;
}

bool NavigationFunction::straight(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                  double gap_m) const {
  const Eigen::Vector2d way = to - from;
  const double length = way.norm(), heading_rad = std::atan2(way.y(), way.x());
  double most_m = 0, most_sure_m = -far_m;  // out of a tight place the robot may go, into one it may not
  // On open floor the shield may be unsure: at speed the robot forgets beside it what it saw ahead.
  for (double s = 0; s <= length; s += ObstacleMap::cell_m) {
    const Eigen::Vector2d p = from + way * (length > 0 ? s / length : 0.0);
    most_m = std::max(most_m, clearance_m(p));
    if (clearance_m(p) < std::min(half_width_m_ + gap_m, most_m - 0.02)) return false;
    const double sure_m = from_body_m(sure_m_, discs_at({p.x(), p.y(), heading_rad}));
    most_sure_m = std::max(most_sure_m, sure_m);
    const bool open = clearance_m(p) >= half_width_m_ + wide_gap_m && sure_m >= most_sure_m - 0.02;
    if (sure_m < unsure_gap_m && s > 0.05 && !open) return false;
  }
  return true;
}

void NavigationFunction::seed() {
  std::fill(goal_.begin(), goal_.end(), std::uint8_t{0});
  const double margin_m = distance_m_ + 2 * block_m;
  const bool whole = inside(block_at(p_OB_ + Eigen::Vector2d(margin_m, margin_m))) &&
                     inside(block_at(p_OB_ - Eigen::Vector2d(margin_m, margin_m)));
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      const bool border = r == 0 || c == 0 || r == size - 1 || c == size - 1;
      const Eigen::Vector2d p = center_m({c, r});
      const double away_m = (p - p_OB_).norm();
      const bool ends_here = border && !whole;
      if (!ends_here && std::abs(away_m - distance_m_) >= 0.8 * block_m) continue;
      const double gap_there_m = clearance_m(p) - half_width_m_;
      if (distance_m_ > 0.0 && gap_there_m < goal_gap_m) continue;
      if (!ends_here && !sees_ball({c, r})) continue;
      double cost_m = ends_here ? std::min(std::max(away_m - distance_m_, 0.0), 9.0) : 0.0;
      if (distance_m_ > 0.0) cost_m += goal_price_m * (price(gap_there_m, far_m) - 1.0);
      goal_[index({c, r})] = 1;
      put(index({c, r}), static_cast<int>(cost_m / quantum_m));
    }
  }
}

/// Of the round body in a block's middle.
double NavigationFunction::price_of(const Block& block) {
  double& known = price_[index(block)];
  if (known == 0) {
    const Eigen::Vector2d p = center_m(block);
    known = price(clearance_m(p) - half_width_m_, at(sure_m_, p) - half_width_m_);
  }
  return known;
}

/// Dijkstra's algorithm, until all around the robot is known.
void NavigationFunction::spread() {
  const Block robot = block_at(p_OR_);
  std::int32_t stop_at = none;
  for (std::int32_t now = 0; !queue_.empty() && now <= stop_at; ++now) {
    while (const auto waiting = queue_.take(now)) {
      const auto cell = static_cast<std::size_t>(*waiting);
      if (cost_[cell] != now) continue;  // it has fallen since
      const Block block{static_cast<int>(cell) % size, static_cast<int>(cell) / size};
      if (block.column == robot.column && block.row == robot.row)
        stop_at = now + static_cast<int>(2.0 / quantum_m);
      for (const Step& step : steps) {
        const Block other{block.column + step.columns, block.row + step.rows};
        if (!inside(other) || cost_[index(other)] <= now + step.least_cost) continue;
        double factor = price_of(other);
        // Out of a tight place the robot may go.
        const bool from_robot =
            std::abs(other.column - robot.column) <= 3 && std::abs(other.row - robot.row) <= 3;
        if (!std::isfinite(factor) && from_robot) factor = no_price;
        if (!std::isfinite(factor)) continue;
        const std::int32_t cost = now + static_cast<std::int32_t>(step.length_m * factor / quantum_m + 0.5);
        if (cost < cost_[index(other)]) put(index(other), cost);
      }
    }
  }
}

void NavigationFunction::update(const ObstacleMap& map, const OccupancyGrid& grid,
                                const Eigen::Vector2d& p_OR, const Eigen::Vector2d& p_OB, double distance_m,
                                double ball_gap_m) {
  // Blocks are counted from the same origin, whatever the window.
  first_ = {map.first().column & ~1, map.first().row & ~1};
  p_OB_ = p_OB;
  p_OR_ = p_OR;
  distance_m_ = distance_m;
  ball_gap_m_ = ball_gap_m;
  measure_clearance(map);
  measure_sure(grid);
  std::fill(sight_.begin(), sight_.end(), Sight::unknown);
  ways_known_ = false;
}

void NavigationFunction::find_ways() {
  if (ways_known_) return;
  ways_known_ = true;
  std::fill(cost_.begin(), cost_.end(), none);
  std::fill(price_.begin(), price_.end(), 0.0);
  queue_.clear();
  seed();
  spread();
}

double NavigationFunction::cost_m(const Block& block) {
  find_ways();
  if (!inside(block) || cost_[index(block)] == none) return std::numeric_limits<double>::infinity();
  return cost_[index(block)] * quantum_m;
}

}  // namespace ballservo
