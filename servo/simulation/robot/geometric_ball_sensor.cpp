#include "servo/simulation/robot/geometric_ball_sensor.hpp"

#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
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

void GeometricSensorOptions::validate() const {
  FaultList faults;
  const auto check = [&](const char* name, double value, double high, const char* allowed) {
    if (value >= 0 && value <= high) return;
    faults.add(name, std::isfinite(value) ? number_text(value) : "not a finite number", allowed);
  };
  check("center_sigma_px", center_sigma_px, 100, "a number from 0 to 100 (px)");
  check("radius_sigma_px", radius_sigma_px, 100, "a number from 0 to 100 (px)");
  check("bias_share", bias_share, 1, "a number from 0 to 1");
  check("min_visible_fraction", min_visible_fraction, 1, "a number from 0 to 1");
  check("min_radius_px", min_radius_px, 1e4, "a number from 0 to 10000 (px)");
  faults.throw_if_any();
}

GeometricBallSensor::GeometricBallSensor(const Camera& camera, const GeometricSensorOptions& options,
                                         std::uint64_t seed)
    : camera_(camera),
      options_(options),
      seed_(seed),
      bias_(three_normals(random_stream(seed, "geometric_ball_sensor_bias"))) {
  options_.validate();
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
