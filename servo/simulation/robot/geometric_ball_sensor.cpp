#include "servo/simulation/robot/geometric_ball_sensor.hpp"

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

}  // namespace ballservo
