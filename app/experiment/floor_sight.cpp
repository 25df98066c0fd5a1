#include "app/experiment/floor_sight.hpp"

#include <algorithm>
#include <cmath>

#include "perception/floor_finder.hpp"
#include "servo/avoidance/floor_fan.hpp"
#include "servo/simulation/robot/floor_sensor.hpp"

namespace ballservo {

namespace {

constexpr double reach_m = 1.8;  // more than the brake from the speed among obstacles, delays included

class GeometricFloorSight final : public FloorSight {
 public:
  GeometricFloorSight(const Scenario& scenario, std::uint64_t seed, double edge_sigma_px)
      : sensor_(scenario.world, scenario.camera.camera, scenario.camera.mount, reach_m, edge_sigma_px,
                scenario.target_ball().name),
        seed_(seed) {}

  FloorScan look(const FloorInput& input) override {
    return sensor_.scan(input.robot, input.time_s, seed_, static_cast<std::uint64_t>(input.frame));
  }

 private:
  FloorSensor sensor_;
  std::uint64_t seed_;
};

/// The pixels of a fan's ray every so many pixels, and how far out each lies.
struct PathOfRay {
  FloorPath path;
  std::vector<double> range_m;
};

PathOfRay path_of(const FloorFan& fan, const FloorFan::Ray& ray, double certain_m) {
  constexpr double spacing_px = 2;
  PathOfRay path;
  for (double range_m = ray.from_m; range_m < fan.reach_m();
       range_m += spacing_px * fan.metres_per_pixel(range_m)) {
    const auto pixel = fan.pixel(ray.bearing_rad, range_m);
    if (!pixel) continue;
    if (range_m < certain_m) ++path.path.certain;
    path.path.pixels.emplace_back(static_cast<int>(std::lround(pixel->x())),
                                  static_cast<int>(std::lround(pixel->y())));
    path.range_m.push_back(range_m);
  }
  return path;
}

class ImageFloorSight final : public FloorSight {
 public:
  explicit ImageFloorSight(const Scenario& scenario)
      : forward_m_(scenario.goal().mount.forward_m),
        fan_(scenario.believed.camera(scenario.camera.camera), scenario.goal().mount, reach_m),
        finder_(lay_paths(scenario.avoidance.grid.start_clear_m)) {}

  FloorScan look(const FloorInput& input) override {
    KnownRound ball;
    if (input.ball) ball = {input.ball->center_px.x(), input.ball->center_px.y(), input.ball->radius_px};
    const std::vector<FloorEdge>& edges = finder_.look(*input.picture, input.ball ? &ball : nullptr);
    FloorScan scan;
    scan.time_s = input.time_s;
    scan.camera_forward_m = forward_m_;
    for (std::size_t k = 0; k < edges.size(); ++k) scan.rays[scan.count++] = ray(k, edges[k]);
    return scan;
  }

 private:
  std::vector<FloorPath> lay_paths(double start_clear_m) {
    constexpr double slack_m = 0.05;
    std::vector<FloorPath> paths;
    for (const FloorFan::Ray& ray : fan_.rays()) {
      PathOfRay path = path_of(fan_, ray, start_clear_m - forward_m_ - slack_m);
      paths.push_back(std::move(path.path));
      ranges_m_.push_back(std::move(path.range_m));
    }
    return paths;
  }

  /// Floor is seen up to the last of its pixels.
  FloorRay ray(std::size_t k, const FloorEdge& edge) const {
    const std::vector<double>& range_m = ranges_m_[k];
    const FloorFan::Ray& of = fan_.rays()[k];
    FloorRay seen{of.bearing_rad, of.from_m, fan_.reach_m(), fan_.reach_m()};
    if (edge.end >= range_m.size()) return seen;
    seen.clear_m = edge.end > 0 ? range_m[edge.end - 1] : of.from_m;
    if (edge.again < range_m.size()) seen.until_m = range_m[edge.again];
    return seen;
  }

  double forward_m_;
  FloorFan fan_;
  std::vector<std::vector<double>> ranges_m_;
  FloorFinder finder_;
};

}  // namespace

std::unique_ptr<FloorSight> make_image_floor_sight(const Scenario& scenario) {
  return std::make_unique<ImageFloorSight>(scenario);
}

std::unique_ptr<FloorSight> make_geometric_floor_sight(const Scenario& scenario, std::uint64_t seed,
                                                       bool exact) {
  constexpr double edge_sigma_px = 1.5;
  return std::make_unique<GeometricFloorSight>(scenario, seed, exact ? 0.0 : edge_sigma_px);
}

}  // namespace ballservo
