#include "servo/avoidance/obstacle_map.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

constexpr float least_chance = 0.002f, most_chance = 0.98f;  // a map that is surer than that learns no more
// How often an observation is made where something stands and where nothing does.
constexpr float unheard = 0.35f;  // a thing in the cone, short of the echo, is not heard
constexpr float echo_right = 0.95f, echo_wrong = 0.02f;
constexpr float seen_as_floor = 0.6f;  // floor is seen where something stands
constexpr float edge_right = 0.8f, edge_wrong = 0.2f;

/// Bayes' rule for "nothing is here", which is said of occupied cells with that rate.
float emptier(float p, float missed) {
  return p == least_chance ? p : std::max(least_chance, p * missed / (p * missed + 1.0f - p));
}

}  // namespace

ObstacleMap::ObstacleMap(const OccupancyGridOptions& options)
    : options_(options), probability_(FloorWindow<size>::cells, prior) {
  arc_.reserve(4096);
}

void ObstacleMap::move(const Pose2& pose) {
  window_.follow(cell_at(pose.x_m, pose.y_m), [this](std::size_t index) { probability_[index] = prior; });
  const double reach_m = started_ ? options_.footprint.reach_m() : options_.start_clear_m;
  const FloorCell low = cell_at(pose.x_m - reach_m, pose.y_m - reach_m),
                  high = cell_at(pose.x_m + reach_m, pose.y_m + reach_m);
  for (int row = low.row; row <= high.row; ++row) {
    for (int column = low.column; column <= high.column; ++column) {
      float& chance = probability_[window_.index({column, row})];
      if (chance == least_chance) continue;
      const Eigen::Vector2d p_R = in_robot_frame(pose, center_m({column, row}));
      if (started_ ? options_.footprint.distance_m(p_R) <= 0.0 : p_R.norm() <= reach_m) chance = least_chance;
    }
  }
  started_ = true;
}

void ObstacleMap::explain(float right, float wrong) {
  float none = 1.0f;
  for (const std::size_t cell : arc_) none *= 1.0f - probability_[cell];
  const float evidence = right * (1.0f - none) + wrong * none;
  if (!(evidence > 0.0f)) return;
  // Where the cell is occupied, at least one is: p(cell | observation) = p right / evidence.
  for (const std::size_t cell : arc_) {
    probability_[cell] = std::clamp(probability_[cell] * right / evidence, least_chance, most_chance);
  }
  arc_.clear();
}

void ObstacleMap::look(const SonarReading& reading, const Pose2& pose_then) {
  const std::optional<Pose2> transducer = transducer_of(reading, pose_then);
  if (!started_ || !transducer || !(reading.range_m >= options_.beam.min_range_m)) return;
  const Eigen::Vector2d p(transducer->x_m, transducer->y_m);
  const Eigen::Vector2d axis(std::cos(transducer->yaw_rad), std::sin(transducer->yaw_rad));
  const double cosine = std::cos(options_.beam.half_angle_rad);
  constexpr double farthest_m = 0.5 * size * cell_m;
  const double tolerance_m = 0.5 * options_.range_error_m + 0.5 * cell_m;
  const double free_m = reading.range_m - tolerance_m;
  const double far_m = std::min(farthest_m, reading.range_m + tolerance_m);
  const bool echo = reading.echo && reading.range_m + tolerance_m <= farthest_m;
  arc_.clear();
  // The cone lies within far_m of the apex, and on the axis' side.
  const Eigen::Vector2d tip = p + axis * far_m;
  const double aside_m = far_m * std::sqrt(1.0 - cosine * cosine);
  const FloorCell low = cell_at(std::min(p.x(), tip.x() - aside_m), std::min(p.y(), tip.y() - aside_m)),
                  high = cell_at(std::max(p.x(), tip.x() + aside_m), std::max(p.y(), tip.y() + aside_m));
  for (int row = low.row; row <= high.row; ++row) {
    for (int column = low.column; column <= high.column; ++column) {
      const FloorCell cell{column, row};
      if (!window_.contains(cell)) continue;
      const Eigen::Vector2d to_cell = center_m(cell) - p;
      const double range_m = to_cell.norm();
      if (range_m > far_m || to_cell.dot(axis) < cosine * range_m) continue;
      if (range_m < free_m) {
        float& chance = probability_[window_.index(cell)];
        chance = emptier(chance, unheard);
      } else if (echo) {
        arc_.push_back(window_.index(cell));
      }
    }
  }
  if (echo) explain(echo_right, echo_wrong);
}

void ObstacleMap::look_at_floor(const FloorScan& scan, const Pose2& pose_then) {
  if (!started_ || scan.count < 2 || scan.count > FloorScan::max_rays) return;
  const Eigen::Vector2d apex = in_world_frame(pose_then, {scan.camera_forward_m, 0.0});
  constexpr double step_m = 0.5 * cell_m;
  for (std::size_t k = 0; k < scan.count; ++k) {
    const FloorRay& ray = scan.rays[k];
    if (!is_sane(ray)) continue;
    const double heading = pose_then.yaw_rad + ray.bearing_rad;
    const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading));
    const double error_m = 0.02 + 0.01 * ray.clear_m * ray.clear_m;
    const bool edge = ray.until_m > ray.clear_m;
    const double end_m = ray.clear_m + (edge ? error_m + cell_m : 0.0);
    arc_.clear();
    FloorCell before{};
    for (double range_m = ray.from_m; range_m <= end_m; range_m += step_m) {
      const Eigen::Vector2d p = apex + range_m * ahead;
      const FloorCell cell = cell_at(p.x(), p.y());
      if (!window_.contains(cell) || (cell.column == before.column && cell.row == before.row)) continue;
      before = cell;
      if (range_m < ray.clear_m - error_m) {
        float& chance = probability_[window_.index(cell)];
        chance = emptier(chance, seen_as_floor);
      } else if (edge) {
        arc_.push_back(window_.index(cell));
      }
    }
    if (edge) explain(edge_right, edge_wrong);
  }
}

}  // namespace ballservo
