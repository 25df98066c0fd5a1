#include "servo/avoidance/navigation_function.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {

namespace {

constexpr double quantum_m = 0.01;
constexpr std::int32_t none = std::numeric_limits<std::int32_t>::max();
constexpr double far_m = 1.2;  // clearances are measured up to this

// Clearances of the axle. The footprint's half width is 0.21 m, its outermost corner 0.37 m away: nearer than
// tight_m the robot would touch, from narrow_m on it can turn on the spot.
constexpr double tight_m = 0.20;             // the axle never goes nearer to a suspected place
constexpr double wide_m = 0.72;              // nearer than this a way costs a little more than on open floor
constexpr double look_ahead_m = 1.2;         // length of the headings that are weighed
constexpr double view_cost_m_per_rad = 0.5;  // of a heading that takes the ball out of the picture
constexpr double turn_cost_m_per_rad = 0.05;
constexpr double virtual_radius_m = 0.18, virtual_s = 8.0;  // of what is put where the robot got stuck

}  // namespace

NavigationFunction::NavigationFunction()
    : clearance_m_(static_cast<std::size_t>(size) * size, static_cast<float>(far_m)),
      cost_(static_cast<std::size_t>(size) * size, none),
      queue_(static_cast<std::size_t>(9 * size) * size) {
}  // a cell may start, and eight neighbours lower its cost

bool NavigationFunction::block_of(const Eigen::Vector2d& p, int& column, int& row) const {
  column = floor_index(p.x(), block_m) - first_column_;
  row = floor_index(p.y(), block_m) - first_row_;
  return column >= 0 && row >= 0 && column < size && row < size;
}

double NavigationFunction::cost_at(const Eigen::Vector2d& p_O) {
  find_ways();
  int column, row;
  if (!block_of(p_O, column, row)) return std::numeric_limits<double>::infinity();
  const std::int32_t cost = cost_[index(column, row)];
  return cost == none ? std::numeric_limits<double>::infinity() : cost * quantum_m;
}

double NavigationFunction::clearance_at(const Eigen::Vector2d& p_O) const {
  int column, row;
  return block_of(p_O, column, row) ? static_cast<double>(clearance_m_[index(column, row)]) : far_m;
}

void NavigationFunction::add_virtual(double x_m, double y_m, double now_s) {
  virtual_[next_virtual_] = {x_m, y_m, now_s + virtual_s};
  next_virtual_ = (next_virtual_ + 1) % virtual_.size();
}

/// Distances to what is suspected: chamfer distance transform in two passes (Borgefors, CVGIP 34, 1986).
void NavigationFunction::measure_clearance(const OccupancyGrid& grid, const Eigen::Vector2d& p_OB,
                                           double ball_gap_m, double now_s) {
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const bool suspected = grid.is_block_suspected(first_column_ + column, first_row_ + row) &&
                             (center(column, row) - p_OB).squaredNorm() > ball_gap_m * ball_gap_m;
      clearance_m_[index(column, row)] = suspected ? 0.0f : static_cast<float>(far_m);
    }
  }
  for (const Virtual& thing : virtual_) {
    if (thing.until_s < now_s) continue;
    for (double dx = -virtual_radius_m; dx <= virtual_radius_m; dx += block_m) {
      for (double dy = -virtual_radius_m; dy <= virtual_radius_m; dy += block_m) {
        int column, row;
        if (block_of({thing.x_m + dx, thing.y_m + dy}, column, row)) clearance_m_[index(column, row)] = 0.0f;
      }
    }
  }
  spread_clearance(+1);
  spread_clearance(-1);
}

/// One pass over rows and columns, up or down (step +1 or -1): each row from the one before it, then from its
/// own cells before.
void NavigationFunction::spread_clearance(int step) {
  constexpr float side = static_cast<float>(block_m), diagonal = static_cast<float>(1.4142135 * block_m);
  const int begin = step > 0 ? 0 : size - 1;
  for (int k = 0; k < size; ++k) {
    float* row = &clearance_m_[index(0, begin + k * step)];
    if (k > 0) {
      const float* before = row - step * size;
      for (int c = 0; c < size; ++c) row[c] = std::min(row[c], before[c] + side);
      for (int c = 1; c < size; ++c) row[c] = std::min(row[c], before[c - 1] + diagonal);
      for (int c = 0; c + 1 < size; ++c) row[c] = std::min(row[c], before[c + 1] + diagonal);
    }
    for (int c = begin + step; c >= 0 && c < size; c += step) row[c] = std::min(row[c], row[c - step] + side);
  }
}

bool NavigationFunction::sees(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const double length = (to - from).norm();
  for (double s = 0; s < length - 0.25; s += 0.5 * block_m) {
    if (clearance_at(from + (to - from) * (s / length)) < 0.5 * block_m) return false;
  }
  return true;
}

bool NavigationFunction::straight(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const double length = (to - from).norm();
  const double enough = std::min(narrow_m + 0.06, clearance_at(from) + 0.01);
  for (double s = 0; s <= length; s += 0.5 * block_m) {
    if (clearance_at(from + (to - from) * (length > 0 ? s / length : 0.0)) <
        (s < 0.4 ? enough : narrow_m + 0.06))
      return false;
  }
  return true;
}

void NavigationFunction::seed(const Eigen::Vector2d& p_OB, double distance_m) {
  int column, row;
  const double margin_m = distance_m + 2 * block_m;
  const bool inside = block_of(p_OB + Eigen::Vector2d(margin_m, margin_m), column, row) &&
                      block_of(p_OB - Eigen::Vector2d(margin_m, margin_m), column, row);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) {
      const bool border = r == 0 || c == 0 || r == size - 1 || c == size - 1;
      const Eigen::Vector2d p = center(c, r);
      const double away_m = (p - p_OB).norm();
      if (clearance_m_[index(c, r)] < narrow_m) continue;
      if (std::abs(away_m - distance_m) < 0.8 * block_m && sees(p, p_OB)) {
        put(index(c, r), 0);
      } else if (border && !inside) {
        const double beyond_m = std::min(std::max(away_m - distance_m, 0.0), 9.0);
        put(index(c, r), static_cast<int>(beyond_m / quantum_m));
      }
    }
  }
}

/// Dijkstra's algorithm, until all that costs at most so much more than the robot's place is known.
void NavigationFunction::spread(const Eigen::Vector2d& p_OR, double beyond_m) {
  int robot_column, robot_row;
  const bool robot_inside = block_of(p_OR, robot_column, robot_row);
  const auto price = [this](double clearance_m) {
    if (clearance_m < narrow_m) return 9.0;
    if (clearance_m < wide_m) return 1.0 + 1.5 * (wide_m - clearance_m) / (wide_m - narrow_m);
    return 1.0;
  };
  std::int32_t stop_at = none;
  for (std::int32_t now = 0; !queue_.empty() && now <= stop_at; ++now) {
    while (const auto waiting = queue_.take(now)) {
      const auto cell = static_cast<std::size_t>(*waiting);
      if (cost_[cell] != now) continue;  // it has fallen since
      const int column = static_cast<int>(cell) % size, row = static_cast<int>(cell) / size;
      if (robot_inside && column == robot_column && row == robot_row) {
        stop_at = now + static_cast<std::int32_t>(beyond_m / quantum_m);
      }
      for (int dr = -1; dr <= 1; ++dr) {
        for (int dc = -1; dc <= 1; ++dc) {
          const int c = column + dc, r = row + dr;
          if ((dc == 0 && dr == 0) || c < 0 || r < 0 || c >= size || r >= size) continue;
          const std::size_t other = index(c, r);
          const double length = (dc != 0 && dr != 0 ? 1.4142135623730951 : 1.0) * block_m;
          // No price is below 1.
          if (cost_[other] <= now + static_cast<std::int32_t>(length / quantum_m)) continue;
          const double clearance_m = clearance_m_[other];
          // Out of a tight place the robot may go, into one it may not.
          if (clearance_m < tight_m && clearance_m <= static_cast<double>(clearance_m_[cell])) {
            const bool from_robot =
                robot_inside && std::abs(c - robot_column) <= 2 && std::abs(r - robot_row) <= 2;
            if (!from_robot) continue;
          }
          const std::int32_t cost =
              now + static_cast<std::int32_t>(length * price(clearance_m) / quantum_m + 0.5);
          if (cost >= cost_[other]) continue;
          put(other, cost);
        }
      }
    }
  }
}

void NavigationFunction::update(const OccupancyGrid& grid, const Eigen::Vector2d& p_OB, double distance_m,
                                double ball_gap_m, double now_s) {
  follow(grid.pose());
  measure_clearance(grid, p_OB, ball_gap_m, now_s);
  p_OB_ = p_OB;
  distance_m_ = distance_m;
  ways_known_ = false;
}

void NavigationFunction::update_from_robot(const OccupancyGrid& grid, double now_s) {
  follow(grid.pose());
  measure_clearance(grid, p_OR_, 0.0, now_s);
  std::fill(cost_.begin(), cost_.end(), none);
  queue_.clear();
  put(index(size / 2 - 1, size / 2 - 1), 0);
  constexpr double everywhere_m = 1e3;
  spread(p_OR_, everywhere_m);
  ways_known_ = true;
}

/// The window lies around the robot.
void NavigationFunction::follow(const Pose2& pose) {
  first_column_ = floor_index(pose.x_m, block_m) - size / 2 + 1;
  first_row_ = floor_index(pose.y_m, block_m) - size / 2 + 1;
  p_OR_ = {pose.x_m, pose.y_m};
}

void NavigationFunction::find_ways() {
  if (ways_known_) return;
  ways_known_ = true;
  std::fill(cost_.begin(), cost_.end(), none);
  queue_.clear();
  seed(p_OB_, distance_m_);
  spread(p_OR_, 1.5 * look_ahead_m);
}

std::optional<double> NavigationFunction::heading(const Pose2& pose, double ball_heading_rad,
                                                  double half_view_rad) {
  find_ways();
  constexpr int headings = 72;
  const Eigen::Vector2d p(pose.x_m, pose.y_m);
  const double enough = std::min(narrow_m, clearance_at(p));
  double best_cost = std::numeric_limits<double>::infinity(), best = 0;
  for (int k = 0; k < headings; ++k) {
    const double heading = pose.yaw_rad + 6.283185307179586 * k / headings;
    const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading));
    double way = std::numeric_limits<double>::infinity();
    for (double s = 0.5 * block_m; s <= look_ahead_m; s += 0.5 * block_m) {
      const Eigen::Vector2d q = p + s * ahead;
      if (clearance_at(q) < (s < 0.3 ? enough - 0.05 : narrow_m - 0.03)) break;
      if (s >= 2.0 * block_m) way = std::min(way, s + cost_at(q));
    }
    const double turn = std::abs(wrap_angle(heading - pose.yaw_rad));
    const double out = std::max(0.0, std::abs(wrap_angle(heading - ball_heading_rad)) - half_view_rad);
    const double cost = way + view_cost_m_per_rad * out + turn_cost_m_per_rad * turn;
    if (cost < best_cost) {
      best_cost = cost;
      best = heading;
    }
  }
  if (!std::isfinite(best_cost)) return std::nullopt;
  return best;
}

}  // namespace ballservo
