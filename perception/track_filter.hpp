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

struct TrackFilterOptions {
  double acceleration_radii_s2 = 60;  ///< process noise: sigma of the acceleration, ball radii per s^2
  double size_acceleration_s2 = 3;    ///< the same of log distance, 1/s^2
  double velocity_radii_s = 20;       ///< sigma of the velocity at first sight
  double size_velocity_s = 1;
  double sigma_floor_radii = 0.03;
};

/// Three independent constant-velocity Kalman filters (Bar-Shalom, Li and Kirubarajan 2001, sec. 6.2: white
/// noise acceleration, constant within each interval).
class TrackFilter {
 public:
  TrackFilter(const BallFeatures& first, double time_s, const TrackFilterOptions& options);

  void predict(double time_s);  ///< a time that is not later changes nothing
  /// Squared Mahalanobis distance of a measurement from the prediction (3 degrees of freedom).
  double distance2(const BallFeatures& measured) const;
  void correct(const BallFeatures& measured);
  /// Takes the measured place as it is and forgets the velocity (after a jump).
  void restart(const BallFeatures& measured);

  Eigen::Vector3d value() const;
  Eigen::Vector3d variance() const;
  Eigen::Vector3d velocity() const;  ///< per s
  double time_s() const { return time_s_; }

 private:
  struct Axis {
    Eigen::Vector2d state;  // value, velocity
    Eigen::Matrix2d covariance;
  };
  Axis axis_[3];
  double time_s_;
  TrackFilterOptions options_;
};

}  // namespace ballservo
