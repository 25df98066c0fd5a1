#include "servo/avoidance/occupancy_grid.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {

// A new epoch after so much of motion: a cell counts as seen when its epoch began.
constexpr double epoch_path_m = 0.01, epoch_turn_rad = 0.03;
constexpr double heard_again_m = 0.2;  // between two firings of a transducer, while things and robot move

// What the camera says of the floor.
constexpr double line_spacing_m = 0.7 * OccupancyGrid::cell_m;
constexpr unsigned lifted_every = 3;  // scans: that floor is seen where something stood is in no hurry
constexpr double depth_m = 0.5;       // of what hides the floor beyond it no more is taken to stand there

/// Every cell of a ray as wide as its part of the fan, from one range to another; some more than once.
template <typename Visit>
void along(const FloorRay& ray, double width_rad, const Eigen::Vector2d& apex, double yaw_rad, double from_m,
           double to_m, const Visit& visit) {
  if (from_m > to_m) return;
  const int lines = std::max(1, static_cast<int>(std::ceil(to_m * width_rad / line_spacing_m)));
  const int steps = static_cast<int>(std::ceil((to_m - from_m) / line_spacing_m));
  for (int line = 0; line < lines; ++line) {
    const double angle = yaw_rad + ray.bearing_rad + width_rad * ((line + 0.5) / lines - 0.5);
    const double c = std::cos(angle), s = std::sin(angle);
    for (int k = 0; k <= steps; ++k) {
      const double range_m = std::min(from_m + k * line_spacing_m, to_m);
      visit(OccupancyGrid::cell_at(apex.x() + range_m * c, apex.y() + range_m * s));
    }
  }
}

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

/// Of a cell seen free too long ago to count in all of the window: odometry moves near places less.
bool OccupancyGrid::still_free(const FloorCell& cell, std::uint32_t seen, Drift drift) const {
  if (seen < first_epoch) return false;
  const Eigen::Vector2d from_robot_m(center_m(cell.column) - pose_.x_m, center_m(cell.row) - pose_.y_m);
  return still_counts(seen, from_robot_m.norm() + half_diagonal_m, drift);
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
      mark_free(FloorRegion::disc(pose.x_m, pose.y_m, options_.start_clear_m), motion_.now, true);
    }
    return;
  }
  const double path_m = distance_m(pose_, pose);
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
  mark_free(FloorRegion::around(options_.footprint, pose, 0), motion_.now, true);
}

/// The newest epoch that had begun by then.
std::uint32_t OccupancyGrid::epoch_at(double time_s) const {
  std::uint32_t number = motion_.now;
  while (number > first_epoch && motion_.now - number + 1 < motion_.epochs.size() &&
         motion_.epoch(number).time_s > time_s)
    --number;
  return number;
}

void OccupancyGrid::mark_free(const FloorRegion& region, std::uint32_t epoch_number, bool by_body) {
  visit_cells_within(region, cell_m, window_, [&](int row, int from, int to) {
    for (int column = from; column <= to; ++column) {
      const std::size_t at = window_.index({column, row});
      if (standing_[at] != 0 && !by_body) continue;
      free_since_[at] = std::max(free_since_[at], epoch_number);
      standing_cells_ -= standing_[at];
      standing_[at] = 0;
    }
  });
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
  const std::optional<Pose2> transducer = transducer_of(reading, pose_then);
  if (!started_ || !transducer) return;
  double& last_range_m = last_range_m_[reading.transducer];
  const double both_m = std::min(reading.range_m, last_range_m);
  const bool heard_before = std::abs(reading.range_m - last_range_m) < heard_again_m;
  last_range_m = reading.range_m;
  const double radius_m = std::min(both_m - options_.range_error_m, options_.look_range_m);
  if (both_m > options_.beam.min_range_m && radius_m > cell_m) {  // no nearer echo can be told apart
    mark_free(FloorRegion::cone(*transducer, options_.beam.half_angle_rad - angle_error_rad, radius_m),
              epoch_at(reading.fired_s), false);
  }
  if (reading.echo && reading.range_m <= options_.look_range_m) mark_arc(reading, *transducer, heard_before);
}

void OccupancyGrid::look_at_floor(const FloorScan& scan, const Pose2& pose_then) {
  if (!started_ || scan.count < 2 || scan.count > FloorScan::max_rays) return;
  const Eigen::Vector2d apex = in_world_frame(pose_then, {scan.camera_forward_m, 0.0});
  const double width_rad = (scan.rays[scan.count - 1].bearing_rad - scan.rays[0].bearing_rad) /
                           static_cast<double>(scan.count - 1);
  if (!(width_rad > 0.0 && width_rad < 0.2)) return;
  ++scans_;
  for (std::size_t k = 0; k < scan.count; ++k) {
    const FloorRay& ray = scan.rays[k];
    if (!is_sane(ray)) continue;
    if (standing_cells_ > 0 && scans_ % lifted_every == 0) {
      along(ray, width_rad, apex, pose_then.yaw_rad, ray.from_m, ray.clear_m - cell_m,
            [this](const FloorCell& cell) {
              if (is_standing(cell)) set_standing(cell, false);
            });
    }
    if (ray.until_m <= ray.clear_m) continue;
    // What the scan before glimpsed too stands; this one's own glimpses do not count.
    along(ray, width_rad, apex, pose_then.yaw_rad, ray.clear_m, std::min(ray.until_m, ray.clear_m + depth_m),
          [this](const FloorCell& cell) {
            if (!in_window(cell)) return;
            std::uint32_t& glimpsed_in = glimpsed_in_[window_.index(cell)];
            if (glimpsed_in == scans_) return;
            if (glimpsed_in == scans_ - 1) {
              set_standing(cell, true);
              take_back(cell);
            }
            glimpsed_in = scans_;
          });
  }
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
                           const Pose2* from) const {
  constexpr double window_m = size * cell_m;
  if (!(std::abs(pose.x_m - pose_.x_m) < window_m && std::abs(pose.y_m - pose_.y_m) < window_m))
    return false;  // absurdly far off, or not a number
  // Cells that come within the margin have their centre within the margin and half a diagonal.
  const FloorRegion region =
      FloorRegion::around(footprint, pose, margin_m + drift_m(drift) + half_diagonal_m);
  const int last_row = index_at(region.y_high_m);
  for (int row = index_at(region.y_low_m); row <= last_row; ++row) {
    const FloorRegion::Span span = region.at(center_m(row));
    if (span.low_m > span.high_m) continue;
    const int first_column = index_at(span.low_m), last_column = index_at(span.high_m);
    const bool is_inside = in_window({first_column, row}) && in_window({last_column, row});
    for (int column = first_column; column <= last_column; ++column) {
      if ((is_inside && is_fresh({column, row}, drift)) || is_free({column, row}, drift)) continue;
      if (from == nullptr || !comes_no_nearer({column, row}, footprint, pose, *from)) return false;
    }
  }
  return true;
}

}  // namespace ballservo
