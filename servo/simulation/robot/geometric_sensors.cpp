#include "servo/simulation/robot/geometric_sensors.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"
#include "calibration/base/random.hpp"

namespace ballservo {

namespace {

constexpr double reference_radius_px = 20;

/// Of the centre's two axes and the radius.
Eigen::Vector3d three_normals(RandomEngine engine) {
  Eigen::Vector3d normals;
  for (double& normal : normals) normal = standard_normal(engine);
  return normals;
}

constexpr double endless_m = std::numeric_limits<double>::infinity();

/// Where a ray over the floor enters an outline and leaves it; empty where it misses.
std::optional<std::pair<double, double>> crossing(const FloorOutline& outline, const Eigen::Vector2d& apex,
                                                  const Eigen::Vector2d& ahead) {
  double enter = -endless_m, leave = endless_m;
  if (outline.radius_m > 0) {
    const Eigen::Vector2d away = outline.points_m.front() - apex;
    const double along = away.dot(ahead);
    const double half2 = outline.radius_m * outline.radius_m - (away.squaredNorm() - along * along);
    if (half2 <= 0) return std::nullopt;
    enter = along - std::sqrt(half2);
    leave = along + std::sqrt(half2);
  } else {
    // A convex outline, counter-clockwise: inside is left of every side.
    for (std::size_t k = 0; k < outline.points_m.size(); ++k) {
      const Eigen::Vector2d a = outline.points_m[k];
      const Eigen::Vector2d side = outline.points_m[(k + 1) % outline.points_m.size()] - a;
      const Eigen::Vector2d inward(-side.y(), side.x());
      const double depth = inward.dot(apex - a), rate = inward.dot(ahead);
      if (std::abs(rate) < 1e-12) {
        if (depth < 0) return std::nullopt;
        continue;
      }
      (rate > 0 ? enter : leave) = rate > 0 ? std::max(enter, -depth / rate) : std::min(leave, -depth / rate);
    }
  }
  if (enter >= leave || leave <= 0) return std::nullopt;
  return std::make_pair(std::max(enter, 0.0), leave);
}

}  // namespace

void declare(OptionVisitor& v, GeometricSensorOptions& options) {
  const NumberRange px = NumberRange::within(0, 100, "px");
  v.number("center_sigma_px", options.center_sigma_px, px, "of a 20 px outline's centre, along each axis");
  v.number("radius_sigma_px", options.radius_sigma_px, px, "of a 20 px outline's radius");
  v.number("bias_share", options.bias_share, NumberRange::within(0, 1, ""),
           "of the variance: what stays the same throughout a run");
  v.number("min_visible_fraction", options.min_visible_fraction, NumberRange::within(0, 1, ""),
           "a ball of which less is seen is not found");
  v.number("min_radius_px", options.min_radius_px, NumberRange::within(0, 1e4, "px"),
           "smaller outlines are not found");
}

GeometricBallSensor::GeometricBallSensor(const Camera& camera, const GeometricSensorOptions& options,
                                         std::uint64_t seed)
    : camera_(camera),
      options_(options),
      seed_(seed),
      bias_(three_normals(random_stream(seed, "geometric_ball_sensor_bias"))) {
  check_options("geometric", options_);
}

BallMeasurement GeometricBallSensor::measure(const BallTruth& truth, double diameter_m, double time_s,
                                             std::uint64_t frame_index) const {
  BallMeasurement measurement;
  measurement.time_s = time_s;
  if (!truth.center_in_view || !truth.outline || truth.visible_fraction < options_.min_visible_fraction ||
      truth.outline->radius_px < options_.min_radius_px) {
    return measurement;
  }
  measurement.state = TrackState::confirmed;
  measurement.p_CB = truth.p_CB;
  if (options_.exact) return measurement;

  const double distance = truth.p_CB.norm();
  const Eigen::Vector3d ray = truth.p_CB / distance;
  const Eigen::Matrix<double, 3, 2> across = perpendicular_basis(ray);
  const double pixel_rad = 1.0 / camera_.focal_px();
  const double radius_px = diameter_m / 2 / distance / pixel_rad;
  const double growth = reference_radius_px / radius_px;
  const double across_sigma_m = distance * pixel_rad * options_.center_sigma_px * growth;
  const double along_sigma_m = distance * options_.radius_sigma_px * growth / radius_px;
  const Eigen::Vector3d noise = three_normals(random_stream(seed_, "geometric_ball_sensor", frame_index));
  const Eigen::Vector3d error =
      std::sqrt(options_.bias_share) * bias_ + std::sqrt(1.0 - options_.bias_share) * noise;
  measurement.p_CB += across_sigma_m * across * error.head<2>() + along_sigma_m * error.z() * ray;
  measurement.covariance_m2 = across_sigma_m * across_sigma_m * across * across.transpose() +
                              along_sigma_m * along_sigma_m * ray * ray.transpose();
  return measurement;
}

FloorSensor::FloorSensor(const World& world, const Camera& camera, const CameraMount& mount, double reach_m,
                         double edge_sigma_px, const std::string& ignored)
    : world_(world),
      mount_(mount),
      fan_(camera, mount, reach_m),
      edge_sigma_px_(edge_sigma_px),
      ignored_(ignored) {
  for (const Obstacle& obstacle : world.obstacles) {
    if (obstacle.bottom_m() < mount.up_m)
      things_.push_back({floor_outline(obstacle), obstacle.bottom_m(), obstacle.top_m()});
  }
}

/// Of an upright thing the bottom of its near side and the top of its far side bound what it hides: a line of
/// sight from height h meets the floor at R and passes at height h (1 - r / R) over the floor at r.
std::optional<FloorSensor::Span> FloorSensor::hidden_by(const Thing& thing, const Eigen::Vector2d& apex,
                                                        const Eigen::Vector2d& ahead) const {
  const auto within = crossing(thing.outline, apex, ahead);
  if (!within) return std::nullopt;
  const double h = mount_.up_m;
  const auto foot_m = [h](double range_m, double height_m) {
    return height_m < h ? range_m * h / (h - height_m) : endless_m;
  };
  return Span{foot_m(within->first, std::max(0.0, thing.bottom_m)), foot_m(within->second, thing.top_m)};
}

/// The lines of sight that touch the ball, within the upright plane of the ray.
std::optional<FloorSensor::Span> FloorSensor::hidden_by(const Ball& ball, double time_s,
                                                        const Eigen::Vector2d& apex,
                                                        const Eigen::Vector2d& ahead) const {
  const Eigen::Vector3d p_W = ball.p_WB(time_s);
  const Eigen::Vector2d away = p_W.head<2>() - apex;
  const double along = away.dot(ahead);
  const double cut2 = ball.radius_m() * ball.radius_m() - (away.squaredNorm() - along * along);
  const double down = mount_.up_m - p_W.z(), distance = std::hypot(along, down);
  if (along <= 0 || cut2 <= 0 || cut2 >= distance * distance) return std::nullopt;
  const double middle = std::atan2(down, along), half = std::asin(std::sqrt(cut2) / distance);
  const auto foot_m = [this](double angle) {
    return angle > 1e-9 ? mount_.up_m / std::tan(std::min(angle, M_PI / 2)) : endless_m;
  };
  return Span{foot_m(middle + half), foot_m(middle - half)};
}

double FloorSensor::to_wall_m(const Eigen::Vector2d& apex, const Eigen::Vector2d& ahead) const {
  const Room& room = world_.room;
  const auto along = [](double from, double way, double low, double high) {
    return way > 0 ? (high - from) / way : way < 0 ? (low - from) / way : endless_m;
  };
  return std::max(0.0, std::min(along(apex.x(), ahead.x(), room.x_min_m, room.x_max_m),
                                along(apex.y(), ahead.y(), room.y_min_m, room.y_max_m)));
}

FloorScan FloorSensor::scan(const Pose2& robot, double time_s, std::uint64_t seed, std::uint64_t frame,
                            double pan_rad) const {
  FloorScan scan;
  scan.time_s = time_s;
  scan.camera_forward_m = mount_.forward_m;
  const Eigen::Vector2d apex = in_world_frame(robot, {mount_.forward_m, 0.0});
  RandomEngine engine = random_stream(seed, "floor_sensor", frame);
  for (const FloorFan::Ray& ray : fan_.rays()) {
    const double heading = robot.yaw_rad + pan_rad + ray.bearing_rad;
    const Eigen::Vector2d ahead(std::cos(heading), std::sin(heading));
    Span first{to_wall_m(apex, ahead), endless_m};
    const auto look = [&first](const std::optional<Span>& span) {
      if (span && span->from_m < first.from_m) first = *span;
    };
    for (const Thing& thing : things_) look(hidden_by(thing, apex, ahead));
    for (const Ball& ball : world_.balls) {
      if (ball.name != ignored_) look(hidden_by(ball, time_s, apex, ahead));
    }
    const double noise_px = edge_sigma_px_ * standard_normal(engine);
    const double reach_m = fan_.reach_m();
    FloorRay seen{ray.bearing_rad, ray.from_m, reach_m, reach_m};
    if (first.from_m < reach_m) {
      const double edge_m = first.from_m + noise_px * fan_.metres_per_pixel(first.from_m);
      seen.clear_m = std::clamp(edge_m, ray.from_m, reach_m);
      seen.until_m = std::clamp(first.until_m, seen.clear_m, reach_m);
    }
    scan.rays[scan.count++] = seen;
  }
  return scan;
}

}  // namespace ballservo
