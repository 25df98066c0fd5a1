#include "perception/tracking/track_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr double size_acceleration_s2 = 3;  // of log distance, as acceleration_radii_s2
// Sigmas of the velocity when the ball appears.
constexpr double velocity_radii_s = 20, size_velocity_s = 1;

// Derivative of (X/Z, Y/Z) by the centre, and back, of a unit direction.
Eigen::Matrix<double, 2, 3> normalized_jacobian(const Eigen::Vector3d& axis) {
  const double inverse = 1 / axis.z();
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << inverse, 0, -axis.x() * inverse * inverse, 0, inverse, -axis.y() * inverse * inverse;
  return jacobian;
}

}  // namespace

BallFeatures features_of(const BallObservation& ball, double sigma_floor_radii) {
  const Eigen::Vector3d& axis = ball.cone.axis;
  const double alpha = ball.cone.alpha_rad;
  BallFeatures features;
  features.value = {axis.x() / axis.z(), axis.y() / axis.z(), -std::log(std::sin(alpha))};
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  jacobian.topLeftCorner<2, 2>() = normalized_jacobian(axis) * perpendicular_basis(axis);
  jacobian(2, 2) = -1 / std::tan(alpha);
  const Eigen::Matrix3d covariance = jacobian * ball.cone_covariance_rad2 * jacobian.transpose();
  const Eigen::Vector3d floor = sigma_floor_radii * Eigen::Vector3d(alpha / axis.z(), alpha / axis.z(), 1);
  features.sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt().cwiseMax(floor);
  return features;
}

TangentCone cone_of(const Eigen::Vector3d& features) {
  return {Eigen::Vector3d(features.x(), features.y(), 1).normalized(),
          std::asin(std::min(0.999, std::exp(-features.z())))};
}

BallPosition position_of(const Eigen::Vector3d& features, const Eigen::Vector3d& variance,
                         const BallRadius& radius) {
  const Eigen::Vector3d ray(features.x(), features.y(), 1);
  const double length = ray.norm(), distance_m = radius.radius_m * std::exp(features.z());
  const Eigen::Vector3d axis = ray / length;
  Eigen::Matrix3d jacobian;
  jacobian.leftCols<2>() =
      (Eigen::Matrix3d::Identity() - axis * axis.transpose()).leftCols<2>() * (distance_m / length);
  jacobian.col(2) = axis * distance_m;
  const Eigen::Vector3d by_radius = axis * (distance_m / radius.radius_m * radius.sigma_m);
  return {axis * distance_m,
          jacobian * variance.asDiagonal() * jacobian.transpose() + by_radius * by_radius.transpose()};
}

void TrackFilter::restart(const BallFeatures& measured) {
  const double radius = std::exp(-measured.value.z());
  for (int i = 0; i < 3; ++i) {
    const double velocity_sigma = i < 2 ? velocity_radii_s * radius : size_velocity_s;
    axis_[i].state = {measured.value(i), 0};
    axis_[i].covariance =
        Eigen::Vector2d(measured.sigma(i) * measured.sigma(i), velocity_sigma * velocity_sigma).asDiagonal();
  }
}

void TrackFilter::predict(double time_s) {
  const double dt = time_s - time_s_;
  if (!(dt > 0)) return;
  time_s_ = time_s;
  const double radius = std::exp(-axis_[2].state.x());
  Eigen::Matrix2d transition;
  transition << 1, dt, 0, 1;
  Eigen::Matrix2d growth;
  growth << dt * dt * dt / 3, dt * dt / 2, dt * dt / 2, dt;
  for (int i = 0; i < 3; ++i) {
    const double acceleration = i < 2 ? acceleration_radii_s2 * radius : size_acceleration_s2;
    axis_[i].state = transition * axis_[i].state;
    axis_[i].covariance = (transition * axis_[i].covariance * transition.transpose()).eval() +
                          acceleration * acceleration * acceleration_lasts_s * growth;
  }
}

double TrackFilter::distance2(const BallFeatures& measured) const {
  return (measured.value - value()).cwiseAbs2().cwiseQuotient(innovation_variance(measured)).sum();
}

double TrackFilter::negative_log_likelihood(const BallFeatures& measured) const {
  return distance2(measured) + innovation_variance(measured).array().log().sum();
}

Eigen::Vector3d TrackFilter::innovation_variance(const BallFeatures& measured) const {
  return variance() + measured.sigma.cwiseAbs2();
}

void TrackFilter::correct(const BallFeatures& measured) {
  for (int i = 0; i < 3; ++i) {
    Axis& axis = axis_[i];
    const Eigen::Vector2d gain =
        axis.covariance.col(0) / (axis.covariance(0, 0) + measured.sigma(i) * measured.sigma(i));
    axis.state += gain * (measured.value(i) - axis.state.x());
    // Joseph's form keeps the covariance positive.
    Eigen::Matrix2d keep = Eigen::Matrix2d::Identity();
    keep.col(0) -= gain;
    axis.covariance = (keep * axis.covariance * keep.transpose() +
                       measured.sigma(i) * measured.sigma(i) * gain * gain.transpose())
                          .eval();
  }
}

Eigen::Vector3d TrackFilter::value() const {
  return {axis_[0].state.x(), axis_[1].state.x(), axis_[2].state.x()};
}
Eigen::Vector3d TrackFilter::variance() const {
  return {axis_[0].covariance(0, 0), axis_[1].covariance(0, 0), axis_[2].covariance(0, 0)};
}

}  // namespace ballservo
