#include "servo/avoidance/moving_things.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

/// Visits the words, and the bits of each, of the columns from first to last of a row that is kept as a ring.
template <typename Visit>
void visit_words(int first, int last, const Visit& visit) {
  while (first <= last) {
    const int bit = first & 63, count = std::min(64 - bit, last - first + 1);
    const std::uint64_t bits = (count == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1) << bit;
    visit(static_cast<std::size_t>((first & (MovingThings::size - 1)) / 64), bits);
    first += count;
  }
}

}  // namespace

void declare(OptionVisitor& v, MovingThingOptions& moving) {
  v.number("speed_mps", moving.speed_mps, NumberRange::within(0, 2, "m/s"),
           "nothing moves faster; 0: nothing moves");
  v.number("radius_m", moving.radius_m, NumberRange::within(0.05, 0.5, "m"),
           "a disc so large fits into everything that moves");
}

MovingThings::MovingThings(const MovingThingOptions& options, const OccupancyGridOptions& grid)
    : options_(options), grid_(grid) {
  for (Row& row : rows_) row.fill(~std::uint64_t{0});
}

void MovingThings::move(double time_s, const Pose2& pose) {
  window_.follow(OccupancyGrid::cell_at(pose.x_m, pose.y_m), [this](std::size_t index) {
    rows_[index / size][index % size / 64] |= std::uint64_t{1} << (index % 64);
  });
  if (!started_) {
    started_ = true;
    exclude(FloorRegion::disc(pose.x_m, pose.y_m, grid_.start_clear_m + options_.radius_m));
  } else {
    const double path_m = distance_m(pose_, pose);
    const double turn_rad = std::abs(wrap_angle(pose.yaw_rad - pose_.yaw_rad));
    grown_m_ += options_.speed_mps * std::max(0.0, time_s - time_s_) +
                grid_.odometry.point_error_m(path_m, turn_rad, grid_.look_range_m);
    grown_m_ = std::min(grown_m_, size * cell_m);  // by then it is everywhere
    for (; grown_m_ >= cell_m; grown_m_ -= cell_m) grow();
  }
  time_s_ = time_s;
  pose_ = pose;
  // What does not overlap the robot has its middle no nearer.
  const Footprint& body = grid_.footprint;
  const double r_m = options_.radius_m;
  exclude(FloorRegion::around({body.front_m + r_m, body.rear_m + r_m, body.half_width_m}, pose, 0));
  exclude(FloorRegion::around({body.front_m, body.rear_m, body.half_width_m + r_m}, pose, 0));
  for (const Eigen::Vector2d& corner_R : body.corners()) {
    const Eigen::Vector2d corner = in_world_frame(pose, corner_R);
    exclude(FloorRegion::disc(corner.x(), corner.y(), r_m));
  }
}

/// By a cell to each side and corner: what moves by no more than a cell's side gets no further.
void MovingThings::grow() {
  const auto sideways = [](const Row& row) {
    Row grown;
    for (std::size_t k = 0; k < row.size(); ++k) {
      const std::uint64_t left = row[(k + row.size() - 1) % row.size()], right = row[(k + 1) % row.size()];
      grown[k] = row[k] | row[k] << 1 | left >> 63 | row[k] >> 1 | right << 63;
    }
    return grown;
  };
  const Row first = sideways(rows_.front());
  Row below = sideways(rows_.back()), here = first;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const Row above = k + 1 < rows_.size() ? sideways(rows_[k + 1]) : first;
    for (std::size_t word = 0; word < here.size(); ++word)
      rows_[k][word] = below[word] | here[word] | above[word];
    below = here;
    here = above;
  }
}

void MovingThings::exclude(const FloorRegion& region) {
  visit_cells_within(region, cell_m, window_, [&](int number, int from, int to) {
    Row& cells = rows_[static_cast<std::size_t>(number & (size - 1))];
    visit_words(from, to, [&cells](std::size_t word, std::uint64_t bits) { cells[word] &= ~bits; });
  });
}

void MovingThings::look(const SonarReading& reading, const Pose2& pose_then) {
  const std::optional<Pose2> transducer = transducer_of(reading, pose_then);
  if (!started_ || !transducer) return;
  double& last_range_m = last_range_m_[reading.transducer];
  const double both_m = std::min(reading.range_m, last_range_m);  // an echo may be missed once
  last_range_m = reading.range_m;
  if (!(both_m > grid_.beam.min_range_m)) return;
  const double radius_m = std::min(both_m - grid_.range_error_m, grid_.look_range_m);
  const double half_rad = grid_.beam.half_angle_rad - OccupancyGrid::angle_error_rad;
  // Things have moved since then.
  const double moved_m = options_.speed_mps * std::max(0.0, time_s_ - reading.fired_s);
  // A disc lies in the cone with a part of it where its middle lies before the arc, or beside a side.
  exclude(FloorRegion::cone(*transducer, half_rad, radius_m + options_.radius_m - moved_m, -moved_m));
  const double beside_m = options_.radius_m * std::cos(half_rad) - moved_m;
  if (radius_m > moved_m && beside_m > 0.0)
    exclude(FloorRegion::cone(*transducer, half_rad, std::hypot(radius_m - moved_m, beside_m), beside_m));
}

bool MovingThings::may_touch(const Footprint& footprint, const Pose2& pose, double margin_m,
                             double later_s) const {
  constexpr double window_m = size * cell_m;
  if (!(std::abs(pose.x_m - pose_.x_m) < window_m && std::abs(pose.y_m - pose_.y_m) < window_m))
    return true;  // absurdly far off, or not a number
  const double around_m =
      margin_m + options_.radius_m + options_.speed_mps * later_s + grown_m_ + OccupancyGrid::half_diagonal_m;
  FloorRegion region = FloorRegion::around(footprint, pose, around_m);
  // The corners are round.
  const double middle_m = 0.5 * (footprint.front_m - footprint.rear_m);
  const Eigen::Vector2d middle = in_world_frame(pose, {middle_m, 0});
  region.disc_x_m = middle.x();
  region.disc_y_m = middle.y();
  region.disc_radius_m = std::hypot(footprint.front_m - middle_m, footprint.half_width_m) + around_m;
  const FloorCell first = window_.first();
  const int last_row = floor_index(region.y_high_m, cell_m);
  for (int number = floor_index(region.y_low_m, cell_m); number <= last_row; ++number) {
    const FloorRegion::Span span = region.at((number + 0.5) * cell_m);
    if (span.low_m > span.high_m) continue;
    const int from = floor_index(span.low_m, cell_m), to = floor_index(span.high_m, cell_m);
    if (number < first.row || number >= first.row + size || from < first.column || to >= first.column + size)
      return true;
    bool there = false;
    const Row& cells = rows_[static_cast<std::size_t>(number & (size - 1))];
    visit_words(from, to,
                [&](std::size_t word, std::uint64_t bits) { there = there || (cells[word] & bits) != 0; });
    if (there) return true;
  }
  return false;
}

}  // namespace ballservo
