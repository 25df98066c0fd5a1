#include "servo/avoidance/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

constexpr double half_diagonal_m = 0.7071067811865476 * OccupancyGrid::cell_m;
// A new epoch after so much of motion: a cell counts as seen when its epoch began.
constexpr double epoch_path_m = 0.01, epoch_turn_rad = 0.03;
constexpr double same_echo_m = 0.2;  // between two firings of a transducer, while things and robot move

}  // namespace

void declare(OptionVisitor& v, OccupancyGridOptions& grid) {
  v.number("start_clear_m", grid.start_clear_m, NumberRange::within(0, 3, "m"),
           "nothing stands within this of the axle at the start");
  v.number("memory_s", grid.memory_s, NumberRange::above(0, 600, "s"),
           "what was seen free counts so long, in motion");
  v.number("drift_allowed_m", grid.drift_allowed_m,
           NumberRange::within(OccupancyGrid::drift_close_m, 0.5, "m"),
           "and until odometry may have drifted so far");
  v.number("look_range_m", grid.look_range_m, NumberRange::within(0.5, 3, "m"),
           "nothing further off is remembered of a firing");
}

/// A convex region of the floor: half planes (inside where n . p <= c) and a disc.
struct OccupancyGrid::Region {
  struct HalfPlane {
    double nx, ny, c;
  };
  std::array<HalfPlane, 4> planes;
  int plane_count = 0;
  double disc_x_m = 0, disc_y_m = 0, disc_radius_m = 0;  // no disc for 0
  double y_low_m = 0, y_high_m = 0;                      // bounds, not tight

  void add(double nx, double ny, double x, double y) {
    planes[static_cast<std::size_t>(plane_count++)] = {nx, ny, nx * x + ny * y};
  }

  /// Empty where low > high.
  Span at(double y_m) const {
    constexpr double far = std::numeric_limits<double>::infinity();
    Span span{-far, far};
    if (disc_radius_m > 0.0) {
      const double dy = y_m - disc_y_m, left = disc_radius_m * disc_radius_m - dy * dy;
      if (left < 0.0) return {1.0, -1.0};
      const double half = std::sqrt(left);
      span = {disc_x_m - half, disc_x_m + half};
    }
    for (int k = 0; k < plane_count; ++k) {
      const HalfPlane& plane = planes[static_cast<std::size_t>(k)];
      const double rest = plane.c - plane.ny * y_m;
      if (plane.nx > 1e-12) {
        span.high_m = std::min(span.high_m, rest / plane.nx);
      } else if (plane.nx < -1e-12) {
        span.low_m = std::max(span.low_m, rest / plane.nx);
      } else if (rest < 0.0) {
        return {1.0, -1.0};
      }
    }
    return span;
  }
};

OccupancyGrid::OccupancyGrid(const OccupancyGridOptions& options)
    : options_(options),
      free_since_(FloorWindow<size>::cells, 0),
      standing_(FloorWindow<size>::cells, 0),
      glimpsed_in_(FloorWindow<size>::cells, 0) {}

bool OccupancyGrid::still_counts(std::uint32_t seen, double distance_m, Drift drift) const {
  if (motion_.now - seen >= motion_.epochs.size()) return false;
  const Epoch& then = motion_.epoch(seen);
  return motion_.sum.motion_s - then.motion_s <= options_.memory_s &&
         options_.odometry.point_error_m(motion_.sum.path_m - then.path_m,
                                         motion_.sum.turn_rad - then.turn_rad, distance_m) <= drift_m(drift);
}

/// Of a cell seen free too long ago to count in all of the window: odometry moves near places less than far
/// ones.
bool OccupancyGrid::still_free(const FloorCell& cell, std::uint32_t seen, Drift drift) const {
  if (seen < first_epoch) return false;
  return still_counts(
      seen, std::hypot(center_m(cell.column) - pose_.x_m, center_m(cell.row) - pose_.y_m) + half_diagonal_m,
      drift);
}

bool OccupancyGrid::is_standing(const FloorCell& cell) const {
  return in_window(cell) && standing_[window_.index(cell)] != 0;
}

void OccupancyGrid::take_back(const FloorCell& cell) {
  std::uint32_t& since = free_since_[window_.index(cell)];
  since = std::min(since, taken_back);
}

/// A cell that enters the window has never been seen.
void OccupancyGrid::forget(std::size_t index) {
  free_since_[index] = never;
  glimpsed_in_[index] = 0;
  standing_cells_ -= standing_[index];
  standing_[index] = 0;
}

void OccupancyGrid::move(double time_s, const Pose2& pose) {
  if (!started_) {
    started_ = true;
    pose_ = pose;
    window_.follow(cell_at(pose.x_m, pose.y_m), [](std::size_t) {});
    motion_.sum.time_s = time_s;
    motion_.epochs[motion_.now] = motion_.sum;
    if (options_.start_clear_m > 0.0) {
      Region disc;
      disc.disc_x_m = pose.x_m;
      disc.disc_y_m = pose.y_m;
      disc.disc_radius_m = options_.start_clear_m;
      disc.y_low_m = pose.y_m - options_.start_clear_m;
      disc.y_high_m = pose.y_m + options_.start_clear_m;
      mark_free(disc, motion_.now, true);
    }
    return;
  }
  const double path_m = std::hypot(pose.x_m - pose_.x_m, pose.y_m - pose_.y_m);
  const double turn_rad = std::abs(wrap_angle(pose.yaw_rad - pose_.yaw_rad));
  const double dt_s = std::max(0.0, time_s - motion_.sum.time_s);
  motion_.sum.time_s = time_s;
  if (path_m < 1e-6 && turn_rad < 1e-6) return;
  motion_.sum.path_m += path_m;
  motion_.sum.turn_rad += turn_rad;
  motion_.sum.motion_s += dt_s;
  pose_ = pose;
  window_.follow(cell_at(pose.x_m, pose.y_m), [this](std::size_t index) { forget(index); });
  constexpr double window_reach_m = 0.75 * size * cell_m;
  for (const Drift drift : {Drift::allowed, Drift::close}) {
    std::uint32_t& fresh = motion_.fresh[static_cast<std::size_t>(drift)];
    while (fresh < motion_.now && !still_counts(fresh, window_reach_m, drift)) ++fresh;
  }
  if (motion_.sum.path_m - motion_.epoch(motion_.now).path_m < epoch_path_m &&
      motion_.sum.turn_rad - motion_.epoch(motion_.now).turn_rad < epoch_turn_rad)
    return;
  ++motion_.now;
  motion_.epochs[motion_.now % motion_.epochs.size()] = motion_.sum;

  // Where the robot stands is free.
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const Footprint& body = options_.footprint;
  Region under;
  under.add(c, s, pose.x_m + c * body.front_m, pose.y_m + s * body.front_m);
  under.add(-c, -s, pose.x_m - c * body.rear_m, pose.y_m - s * body.rear_m);
  under.add(-s, c, pose.x_m - s * body.half_width_m, pose.y_m + c * body.half_width_m);
  under.add(s, -c, pose.x_m + s * body.half_width_m, pose.y_m - c * body.half_width_m);
  const double reach_m = body.reach_m();
  under.y_low_m = pose.y_m - reach_m;
  under.y_high_m = pose.y_m + reach_m;
  mark_free(under, motion_.now, true);
}

/// The newest epoch that had begun by then.
std::uint32_t OccupancyGrid::epoch_at(double time_s) const {
  std::uint32_t number = motion_.now;
  while (number > first_epoch && motion_.now - number + 1 < motion_.epochs.size() &&
         motion_.epoch(number).time_s > time_s)
    --number;
  return number;
}

/// A cell lies within a convex region exactly when its upper and its lower edge do.
void OccupancyGrid::mark_free(const Region& region, std::uint32_t epoch_number, bool by_body) {
  const int first = std::max(index_at(region.y_low_m), window_.first().row);
  const int last = std::min(index_at(region.y_high_m), window_.first().row + size - 1);
  Span below = region.at(first * cell_m);
  for (int row = first; row <= last; ++row) {
    const Span above = region.at((row + 1) * cell_m);
    const double low_m = std::max(below.low_m, above.low_m), high_m = std::min(below.high_m, above.high_m);
    const bool both = below.low_m <= below.high_m && above.low_m <= above.high_m && low_m < high_m;
    below = above;
    if (!both) continue;
    const int first_in = std::max(static_cast<int>(std::ceil(low_m / cell_m)), window_.first().column);
    const int last_in = std::min(index_at(high_m) - 1, window_.first().column + size - 1);
    for (int column = first_in; column <= last_in; ++column) {
      const std::size_t at = window_.index({column, row});
      if (standing_[at] != 0 && !by_body) continue;
      free_since_[at] = std::max(free_since_[at], epoch_number);
      standing_cells_ -= standing_[at];
      standing_[at] = 0;
    }
  }
}

void OccupancyGrid::mark_arc(const SonarReading& reading, const Pose2& transducer, bool heard_before) {
  const double half = options_.beam.half_angle_rad;
  const double near_m = std::max(0.0, reading.range_m - options_.range_error_m);
  const double far_m = reading.range_m + options_.range_error_m;
  const int radii = std::max(1, static_cast<int>(std::ceil((far_m - near_m) / (0.7 * cell_m))));
  const double step_rad = 0.5 * cell_m / std::max(far_m, 0.5 * cell_m);
  const int steps = static_cast<int>(std::ceil(half / step_rad));
  const auto each = [&](const auto& visit) {
    for (int k = -steps; k <= steps; ++k) {
      const double angle = transducer.yaw_rad + half * k / steps;
      const double c = std::cos(angle), s = std::sin(angle);
      for (int r = 0; r <= radii; ++r) {
        const double range_m = near_m + (far_m - near_m) * r / radii;
        const FloorCell cell = cell_at(transducer.x_m + range_m * c, transducer.y_m + range_m * s);
        if (in_window(cell) && visit(cell)) return true;
      }
    }
    return false;
  };
  const bool explained = each([this](const FloorCell& cell) { return !is_free(cell); });
  if (!explained && !heard_before) return;  // another's ping, perhaps
  each([this, explained](const FloorCell& cell) {
    if (explained && is_free(cell)) return false;
    take_back(cell);
    return false;
  });
}

void OccupancyGrid::look(const SonarReading& reading, const Pose2& pose_then) {
  const bool sane = reading.transducer < sonar_count && std::isfinite(reading.range_m) &&
                    std::isfinite(reading.fired_s) && reading.range_m >= 0.0 && started_;
  if (!sane) return;
  const SonarMount& mount = pioneer_3dx_sonars[reading.transducer];
  const Eigen::Vector2d p = in_world_frame(pose_then, {mount.x_m, mount.y_m});
  const Pose2 transducer{p.x(), p.y(), pose_then.yaw_rad + mount.heading_rad};

  double& last_range_m = last_range_m_[reading.transducer];
  const double both_m = std::min(reading.range_m, last_range_m);
  const bool heard_before = std::abs(reading.range_m - last_range_m) < same_echo_m;
  last_range_m = reading.range_m;
  const double radius_m = std::min(both_m - options_.range_error_m, options_.look_range_m);
  if (both_m > options_.beam.min_range_m && radius_m > cell_m) {  // no nearer echo can be told apart
    const double half = options_.beam.half_angle_rad - angle_error_rad;
    const double right = transducer.yaw_rad - half, left = transducer.yaw_rad + half;
    Region cone;
    cone.add(std::sin(right), -std::cos(right), p.x(), p.y());
    cone.add(-std::sin(left), std::cos(left), p.x(), p.y());
    cone.disc_x_m = p.x();
    cone.disc_y_m = p.y();
    cone.disc_radius_m = radius_m;
    const double y_right = p.y() + radius_m * std::sin(right), y_left = p.y() + radius_m * std::sin(left);
    cone.y_low_m = std::min({p.y(), y_right, y_left});
    cone.y_high_m = std::max({p.y(), y_right, y_left});
    // The arc reaches further than its ends where it passes straight up or down.
    if (std::cos(right) * std::cos(left) < 0.0) {
      (std::sin(transducer.yaw_rad) > 0.0 ? cone.y_high_m : cone.y_low_m) =
          p.y() + (std::sin(transducer.yaw_rad) > 0.0 ? radius_m : -radius_m);
    }
    mark_free(cone, epoch_at(reading.fired_s), false);
  }
  if (reading.echo && reading.range_m <= options_.look_range_m) mark_arc(reading, transducer, heard_before);
}

bool OccupancyGrid::comes_no_nearer(const FloorCell& cell, const Footprint& footprint, const Pose2& pose,
                                    const Pose2& from) const {
  const Eigen::Vector2d p(center_m(cell.column), center_m(cell.row));
  const auto distance_m = [&footprint, &p](const Pose2& at) {
    return footprint.distance_m(in_robot_frame(at, p));
  };
  const double now_m = distance_m(from);
  const bool known = in_window(cell) && free_since_[window_.index(cell)] != never;
  constexpr double rounding_m = 1e-6;
  return (now_m > half_diagonal_m || known) && distance_m(pose) >= now_m - rounding_m;
}

bool OccupancyGrid::covers(const Footprint& footprint, const Pose2& pose, double margin_m, Drift drift,
                           FloorCell* obstacle, const Pose2* from) const {
  constexpr double window_m = size * cell_m;
  if (!(std::abs(pose.x_m - pose_.x_m) < window_m && std::abs(pose.y_m - pose_.y_m) < window_m)) {
    if (obstacle != nullptr) *obstacle = cell_at(pose_.x_m, pose_.y_m);
    return false;  // absurdly far off, or not a number
  }
  // Cells that come within the margin have their centre within the margin and half a diagonal.
  const double around_m = margin_m + drift_m(drift) + half_diagonal_m;
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const double front = footprint.front_m + around_m, rear = footprint.rear_m + around_m;
  const double side = footprint.half_width_m + around_m;
  const double up = std::max(s * front, -s * rear) + std::abs(c) * side;
  const double down = std::max(-s * front, s * rear) + std::abs(c) * side;
  const int last_row = index_at(pose.y_m + up);
  for (int row = index_at(pose.y_m - down); row <= last_row; ++row) {
    // Along the row: -rear <= c x + s y <= front, |-s x + c y| <= side.
    const double y = center_m(row) - pose.y_m;
    double low = -1e9, high = 1e9;
    const auto cut = [&low, &high](double slope, double at_least, double at_most) {
      if (std::abs(slope) < 1e-9) {
        if (at_least > 0.0 || at_most < 0.0) high = -1e9;
        return;
      }
      const double a = at_least / slope, b = at_most / slope;
      low = std::max(low, std::min(a, b));
      high = std::min(high, std::max(a, b));
    };
    cut(c, -rear - s * y, front - s * y);
    cut(-s, -side - c * y, side - c * y);
    if (low > high) continue;
    const int last_column = index_at(pose.x_m + high);
    for (int column = index_at(pose.x_m + low); column <= last_column; ++column) {
      if (!is_free({column, row}, drift)) {
        if (from != nullptr && comes_no_nearer({column, row}, footprint, pose, *from)) continue;
        if (obstacle != nullptr) *obstacle = {column, row};
        return false;
      }
    }
  }
  return true;
}

}  // namespace ballservo
