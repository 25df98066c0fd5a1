#include "perception/tracking/track_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr double sigma_floor_radii = 0.03;  // of a measurement, as a fraction of the apparent radius
// What a ball radius of motion sideways is to the log distance, which changes less and is measured worse.
constexpr double size_share = 0.015;
// Sigmas of the velocity when the ball appears, and when it is thrown: 3 m/s of a ball of 35 mm.
constexpr double velocity_radii_s = 20, thrown_radii_s = 80;
// Gravity is 90 radii per s^2 of a football, 490 of a table tennis ball. What slows a ball that is left to
// itself (friction, air) is not modelled: the process noise of rolling and flying balls.
constexpr double gravity_radii_s2 = 300, free_radii_s2 = 15;
constexpr std::array<double, 3> at_first{0.5, 0.3, 0.2};
// How likely another motion turns into this one by the next measurement: seldom into flight. Below such a
// probability none is believed.
constexpr std::array<double, 3> begins{0.05, 0.05, 0.007};
constexpr double least_probability = 0.01;

// Of an axis: its unit for a ball that appears so large.
double unit(int axis, double radius) { return axis < 2 ? radius : size_share; }

// Derivative of (X/Z, Y/Z) by the centre, and back, of a unit direction.
Eigen::Matrix<double, 2, 3> normalized_jacobian(const Eigen::Vector3d& axis) {
  const double inverse = 1 / axis.z();
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << inverse, 0, -axis.x() * inverse * inverse, 0, inverse, -axis.y() * inverse * inverse;
  return jacobian;
}

}  // namespace

BallFeatures features_of(const BallObservation& ball) {
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

TrackFilter::TrackFilter(const BallFeatures& first, double time_s) : time_s_(time_s), measured_s_(time_s) {
  const double radius = std::exp(-first.value.z());
  for (int motion = 0; motion < motions; ++motion) {
    Model& model = models_[motion];
    model.probability = at_first[static_cast<std::size_t>(motion)];
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d sigma(first.sigma(i),
                                  unit(i, radius) * (motion == flying ? thrown_radii_s : velocity_radii_s),
                                  unit(i, radius) * gravity_radii_s2);
      model.axis[i] = {{first.value(i), 0, 0}, sigma.cwiseAbs2().asDiagonal()};
    }
  }
}

void TrackFilter::predict(double time_s) {
  const double dt = time_s - time_s_;
  if (!(dt > 0)) return;
  time_s_ = time_s;
  Eigen::Matrix3d growth = Eigen::Matrix3d::Zero();
  growth.topLeftCorner<2, 2>() << dt * dt * dt / 3, dt * dt / 2, dt * dt / 2, dt;
  for (int motion = 0; motion < motions; ++motion) {
    Model& model = models_[motion];
    const double radius = std::exp(-model.axis[2].state.x());
    const double noise = motion == carried ? acceleration_radii_s2 : free_radii_s2;
    Eigen::Matrix3d transition;
    transition << 1, dt, dt * dt / 2, 0, 1, dt, 0, 0, 1;
    // What does not fly has no acceleration that lasts; what it would have, should it begin to, is not known.
    if (motion != flying) transition.col(2).setZero();
    for (int i = 0; i < 3; ++i) {
      Axis& axis = model.axis[i];
      axis.state = (transition * axis.state).eval();
      axis.covariance = (transition * axis.covariance * transition.transpose()).eval();
      axis.covariance += std::pow(unit(i, radius) * noise, 2) * acceleration_lasts_s * growth;
      if (motion != flying) axis.covariance(2, 2) = std::pow(unit(i, radius) * gravity_radii_s2, 2);
    }
  }
}

double TrackFilter::distance2(const Model& model, const BallFeatures& measured) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const Axis& axis = model.axis[i];
    sum += std::pow(measured.value(i) - axis.state.x(), 2) /
           (axis.covariance(0, 0) + measured.sigma(i) * measured.sigma(i));
  }
  return sum;
}

double TrackFilter::log_likelihood(const Model& model, const BallFeatures& measured) {
  double determinant = 1;
  for (int i = 0; i < 3; ++i)
    determinant *= model.axis[i].covariance(0, 0) + measured.sigma(i) * measured.sigma(i);
  return -0.5 * (distance2(model, measured) + std::log(determinant));
}

double TrackFilter::distance2(const BallFeatures& measured) const {
  double least = std::numeric_limits<double>::infinity();
  for (const Model& model : models_)
    if (model.probability >= least_probability) least = std::min(least, distance2(model, measured));
  return least;
}

double TrackFilter::negative_log_likelihood(const BallFeatures& measured) const {
  double sum = 0;
  for (const Model& model : models_) sum += model.probability * std::exp(log_likelihood(model, measured));
  return sum > 0 ? -2 * std::log(sum) : -2 * log_likelihood(likeliest(), measured);
}

void TrackFilter::correct(const BallFeatures& measured) {
  double logs[motions], largest = -std::numeric_limits<double>::infinity(), sum = 0;
  for (int motion = 0; motion < motions; ++motion) {
    logs[motion] = std::log(models_[motion].probability) + log_likelihood(models_[motion], measured);
    largest = std::max(largest, logs[motion]);
  }
  for (double& log : logs) sum += log = std::exp(log - largest);
  for (int motion = 0; motion < motions; ++motion) {
    Model& model = models_[motion];
    model.probability = logs[motion] / sum;
    for (int i = 0; i < 3; ++i) {
      Axis& axis = model.axis[i];
      const double variance = measured.sigma(i) * measured.sigma(i);
      const Eigen::Vector3d gain = axis.covariance.col(0) / (axis.covariance(0, 0) + variance);
      axis.state += gain * (measured.value(i) - axis.state.x());
      // Joseph's form keeps the covariance positive.
      Eigen::Matrix3d keep = Eigen::Matrix3d::Identity();
      keep.col(0) -= gain;
      axis.covariance =
          (keep * axis.covariance * keep.transpose() + variance * gain * gain.transpose()).eval();
    }
  }
  measured_s_ = time_s_;
  mix();
}

// Each motion goes on from what the others left, as likely as they turned into it.
void TrackFilter::mix() {
  const Model before[motions] = {models_[0], models_[1], models_[2]};
  for (int to = 0; to < motions; ++to) {
    Model& mixed = models_[to];
    double weights[motions];
    mixed.probability = 0;
    for (int from = 0; from < motions; ++from) {
      double turns = begins[static_cast<std::size_t>(to)];
      if (from == to) turns += 1 - begins[carried] - begins[rolling] - begins[flying];
      mixed.probability += weights[from] = turns * before[from].probability;
    }
    for (int i = 0; i < 3; ++i) {
      Axis& axis = mixed.axis[i];
      axis.state.setZero();
      axis.covariance.setZero();
      for (int from = 0; from < motions; ++from)
        axis.state += weights[from] / mixed.probability * before[from].axis[i].state;
      for (int from = 0; from < motions; ++from) {
        const Eigen::Vector3d apart = before[from].axis[i].state - axis.state;
        axis.covariance +=
            weights[from] / mixed.probability * (before[from].axis[i].covariance + apart * apart.transpose());
      }
    }
  }
}

void TrackFilter::correct_after_jump(const BallFeatures& measured) {
  const double duration_s = std::max(1e-3, time_s_ - measured_s_);
  for (int motion = 0; motion < motions; ++motion) {
    Model& model = models_[motion];
    model.probability = at_first[static_cast<std::size_t>(motion)];
    for (int i = 0; i < 3; ++i) {
      const double radius = std::exp(-measured.value.z());
      const Eigen::Vector3d moved(duration_s, 1, 0);
      model.axis[i].covariance += std::pow(unit(i, radius) * thrown_radii_s, 2) * moved * moved.transpose();
    }
  }
  correct(measured);
}

void TrackFilter::lose() {
  for (Model& model : models_) {
    // A ball that goes behind something or over the border seems to shrink: unseen, it keeps its size.
    model.axis[2].state.tail<2>().setZero();
    for (Axis& axis : model.axis) {
      for (int derivative = 1; derivative < 3; ++derivative) {
        double& value = axis.state(derivative);
        const double excess = value * value - axis.covariance(derivative, derivative);
        value = excess > 0 ? excess / value : 0;
      }
    }
  }
}

const TrackFilter::Model& TrackFilter::likeliest() const {
  return *std::max_element(models_, models_ + motions,
                           [](const Model& a, const Model& b) { return a.probability < b.probability; });
}

Eigen::Vector3d TrackFilter::derivative(int order) const {
  const Axis* axis = likeliest().axis;
  return {axis[0].state(order), axis[1].state(order), axis[2].state(order)};
}

Eigen::Vector3d TrackFilter::variance() const {
  const Eigen::Vector3d middle = value();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Model& model : models_) {
    for (int i = 0; i < 3; ++i)
      sum(i) += model.probability *
                (model.axis[i].covariance(0, 0) + std::pow(model.axis[i].state.x() - middle(i), 2));
  }
  return sum;
}

}  // namespace ballservo
