// A ball's motion as the camera sees it: of direction and apparent size, with covariance.
#pragma once

#include <Eigen/Core>

#include "perception/ball_observation.hpp"

namespace ballservo {

/// What is filtered: (X/Z, Y/Z, log(|C|/R)) of the ball's centre. The picture alone gives all three.
struct BallFeatures {
  Eigen::Vector3d value{0, 0, 0};
  Eigen::Vector3d sigma{0, 0, 0};
};

/// Features of a ball as it was seen. Their sigmas have a floor: what an occluded or blurred outline may be
/// wrong by beyond its own residuals.
BallFeatures features_of(const BallObservation& ball);

/// The cone that has these features.
TangentCone cone_of(const Eigen::Vector3d& features);

/// Centre (m) and covariance (m^2) of a ball of that radius with features of that variance.
BallPosition position_of(const Eigen::Vector3d& features, const Eigen::Vector3d& variance,
                         const BallRadius& radius);

/// A carried ball's process noise: sigma of an acceleration (ball radii per s^2) that is another one every so
/// long.
inline constexpr double acceleration_radii_s2 = 200, acceleration_lasts_s = 1.0 / 30;

/// Three motions that a ball obeys, told apart by their likelihood: carried (a hand changes its velocity at
/// will), rolling (it keeps it) and flying (a constant acceleration in the picture, which gravity gives it
/// and nobody knows). An interacting multiple model filter (Blom and Bar-Shalom 1988) of white noise
/// acceleration (Bar-Shalom, Li and Kirubarajan 2001, sec. 6.2.2), each axis alone. The motions mix when a
/// measurement comes, so whatever the rate of the pictures, the prediction for a later time is the same.
class TrackFilter {
 public:
  TrackFilter(const BallFeatures& first, double time_s);

  void predict(double time_s);  ///< a time that is not later changes nothing
  /// Squared Mahalanobis distance of a measurement from the nearest prediction of a motion that is believed
  /// (3 degrees of freedom).
  double distance2(const BallFeatures& measured) const;
  /// Twice the negative log-likelihood of a measurement, but for a constant: with the predicted covariance's
  /// determinant, without which the least certain prediction would be the nearest.
  double negative_log_likelihood(const BallFeatures& measured) const;
  void correct(const BallFeatures& measured);
  /// The same for a ball that was struck since it was last measured: its velocity then is anything that a
  /// throw gives, and is told by how far it came.
  void correct_after_jump(const BallFeatures& measured);
  /// The ball is no longer seen: of its velocity counts what is significant (James and Stein 1961, the
  /// positive part), and of its acceleration, lest it drifts away on noise; its size stays.
  void lose();

  // Of the likeliest motion; the variance also says how far the others are from it.
  Eigen::Vector3d value() const { return derivative(0); }
  Eigen::Vector3d variance() const;
  Eigen::Vector3d velocity() const { return derivative(1); }  ///< per s

 private:
  enum Motion { carried, rolling, flying, motions };
  struct Axis {
    Eigen::Vector3d state;  // value, velocity, acceleration
    Eigen::Matrix3d covariance;
  };
  struct Model {
    Axis axis[3];
    double probability;
  };
  static double distance2(const Model& model, const BallFeatures& measured);
  static double log_likelihood(const Model& model, const BallFeatures& measured);
  const Model& likeliest() const;
  Eigen::Vector3d derivative(int order) const;
  void mix();

  Model models_[motions];
  double time_s_, measured_s_;
};

}  // namespace ballservo
