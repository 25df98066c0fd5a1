// A ball's motion as the camera sees it: constant velocity of direction and apparent size, with covariance.
#pragma once

#include <Eigen/Core>

#include "perception/ball_observation.hpp"

namespace ballservo {

/// What is filtered: (X/Z, Y/Z, log(|C|/R)) of the ball's centre. The picture alone gives all three.
struct BallFeatures {
  Eigen::Vector3d value{0, 0, 0};
  Eigen::Vector3d sigma{0, 0, 0};
};

/// Features of a ball as it was seen. `sigma_floor_radii` bounds the sigmas from below, as a fraction of its
/// apparent radius (what an occluded or blurred outline may be wrong by beyond its own residuals).
BallFeatures features_of(const BallObservation& ball, double sigma_floor_radii);

/// The cone that has these features.
TangentCone cone_of(const Eigen::Vector3d& features);

/// Centre (m) and covariance (m^2) of a ball of that radius with features of that variance.
BallPosition position_of(const Eigen::Vector3d& features, const Eigen::Vector3d& variance,
                         const BallRadius& radius);

/// Process noise: sigma of an acceleration (ball radii per s^2) that is another one every so long.
inline constexpr double acceleration_radii_s2 = 200, acceleration_lasts_s = 1.0 / 30;

/// Three independent constant-velocity Kalman filters (Bar-Shalom, Li and Kirubarajan 2001, sec. 6.2.2: white
/// noise acceleration in continuous time, of density acceleration^2 times how long it lasts). Whatever the
/// rate of the pictures, the prediction for a later time has the same covariance.
class TrackFilter {
 public:
  TrackFilter(const BallFeatures& first, double time_s) : time_s_(time_s) { restart(first); }

  void predict(double time_s);  ///< a time that is not later changes nothing
  /// Squared Mahalanobis distance of a measurement from the prediction (3 degrees of freedom).
  double distance2(const BallFeatures& measured) const;
  /// Twice the negative log-likelihood of a measurement, but for a constant: the squared distance, and the
  /// log of the predicted covariance's determinant, without which the least certain prediction would be the
  /// nearest.
  double negative_log_likelihood(const BallFeatures& measured) const;
  void correct(const BallFeatures& measured);
  /// Takes the measured place as it is and forgets the velocity (after a jump).
  void restart(const BallFeatures& measured);

  Eigen::Vector3d value() const;
  Eigen::Vector3d variance() const;

 private:
  struct Axis {
    Eigen::Vector2d state;  // value, velocity
    Eigen::Matrix2d covariance;
  };
  Eigen::Vector3d innovation_variance(const BallFeatures& measured) const;

  Axis axis_[3];
  double time_s_;
};

}  // namespace ballservo
