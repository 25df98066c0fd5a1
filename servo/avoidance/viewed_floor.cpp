#include "servo/avoidance/viewed_floor.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {
constexpr int directions = 36;  // of a turn on the spot
constexpr double least =
    0.05;  // so likely is the ball behind the start, as against ahead, or far from where it was
constexpr double lost_m = 1.0;  // half as likely so far from where it was lost
constexpr double step_m = ViewedFloor::block_m;
}  // namespace

/// The blocks of the window along a line of sight, until something stands in it.
template <typename Visit>
void ViewedFloor::along(const Eigen::Vector2d& from, double heading_rad, const OccupancyGrid& grid,
                        const Visit& visit) const {
  const Eigen::Vector2d ahead(std::cos(heading_rad), std::sin(heading_rad));
  for (double range_m = 0.5 * step_m; range_m < far_m; range_m += step_m) {
    const Eigen::Vector2d p = from + range_m * ahead;
    const int column = floor_index(p.x(), block_m), row = floor_index(p.y(), block_m);
    const bool inside = column >= first_column_ && row >= first_row_ && column < first_column_ + size &&
                        row < first_row_ + size;
    if (!inside || grid.is_block_suspected(column, row)) return;
    visit(column, row, range_m);
  }
}

void ViewedFloor::follow(const Pose2& pose) {
  const int column = floor_index(pose.x_m, block_m) - size / 2,
            row = floor_index(pose.y_m, block_m) - size / 2;
  const auto steps = [](int from, int to) { return std::min(std::abs(to - from), size); };
  const int columns = steps(first_column_, column), rows = steps(first_row_, row);
  for (int k = 0; k < columns; ++k) {
    const int entering = column > first_column_ ? column + size - 1 - k : column + k;
    for (int r = 0; r < size; ++r) viewed_[index(entering, r)] = 0;
  }
  for (int k = 0; k < rows; ++k) {
    const int entering = row > first_row_ ? row + size - 1 - k : row + k;
    for (int c = 0; c < size; ++c) viewed_[index(c, entering)] = 0;
  }
  first_column_ = column;
  first_row_ = row;
}

void ViewedFloor::look(const Pose2& pose, double half_view_rad, const OccupancyGrid& grid) {
  follow(pose);
  if (!start_) start_ = pose;
  const double apart_rad = step_m / far_m;
  const int rays = static_cast<int>(half_view_rad / apart_rad);
  for (int k = -rays; k <= rays; ++k) {
    along({pose.x_m, pose.y_m}, pose.yaw_rad + k * apart_rad, grid,
          [this](int column, int row, double) { viewed_[index(column, row)] = 1; });
  }
}

/// From 1, ahead of the start or where the ball was lost, to `least`.
double ViewedFloor::likely(const Eigen::Vector2d& p_O) const {
  if (p_OB_) return least + (1.0 - least) / (1.0 + (p_O - *p_OB_).squaredNorm() / (lost_m * lost_m));
  if (!start_) return 1.0;
  const Eigen::Vector2d p_R = in_robot_frame(*start_, p_O);
  const double ahead = 0.5 + 0.5 * p_R.x() / std::max(p_R.norm(), 1e-6);
  return least + (1.0 - least) * ahead * ahead;
}

double ViewedFloor::new_from_m2(const Eigen::Vector2d& p_O, const OccupancyGrid& grid) const {
  double sum_m2 = 0;
  constexpr double apart_rad = 6.283185307179586 / directions;
  for (int k = 0; k < directions; ++k) {
    along(p_O, k * apart_rad, grid, [&](int column, int row, double range_m) {
      if (viewed_[index(column, row)] != 0) return;
      sum_m2 += range_m * apart_rad * step_m * likely({(column + 0.5) * block_m, (row + 0.5) * block_m});
    });
  }
  return sum_m2;
}

}  // namespace ballservo
