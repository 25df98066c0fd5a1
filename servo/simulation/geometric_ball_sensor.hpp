// Perception without pictures: the ball's true centre, exactly or with the error of a fit to its outline.
#pragma once

#include <cstdint>
#include <optional>

#include "calibration/camera/camera.hpp"
#include "servo/ball_measurement.hpp"
#include "servo/simulation/truth.hpp"

namespace ballservo {

/// The sigmas are those of an outline of 20 px radius; of another, r px, they are 20 / r times as large:
/// small outlines err more. Law and defaults are measured: root mean square errors of the frames of
/// static_ball.yaml at level image, seeds 201 and 202 (538 frames, 7 to 30 px), in five ranges of the radius.
/// Real errors are also correlated from frame to frame while the robot stands, which these are not.
struct GeometricSensorOptions {
  bool exact = false;              ///< level `truth`: no noise
  double center_sigma_px = 0.023;  ///< of the outline's centre, along each axis, at 20 px
  double radius_sigma_px = 0.022;  ///< of the outline's radius, at 20 px
  double min_visible_fraction = 0.5;
  double min_radius_px = 3.0;  ///< smaller outlines are not found

  /// Throws InputError for sigmas that are negative or not finite, or a fraction outside 0 to 1.
  void validate() const;
};

class GeometricBallSensor {
 public:
  GeometricBallSensor(const Camera& camera, const GeometricSensorOptions& options);

  /// What perception would say of the ball in this frame: `confirmed`, or `none` where its centre lies
  /// outside the picture, too little of it is seen, or it is too small.
  ///
  /// The errors are those of the outline's centre (two normals) and radius (one) of (seed, frame_index),
  /// carried to 3-D: a centre's error of s px turns the ray by s / f, a radius' error of s px changes the
  /// distance by distance * s / r. The covariance says the same.
  BallMeasurement measure(const BallTruth& truth, double diameter_m, double time_s, std::uint64_t seed,
                          std::uint64_t frame_index) const;

 private:
  Camera camera_;
  GeometricSensorOptions options_;
};

}  // namespace ballservo
