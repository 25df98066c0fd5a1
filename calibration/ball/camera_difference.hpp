// How two calibrations of one camera disagree: in the picture, and at a ball.
//
// Each calibration points its camera frame as it likes: a frame turned by a hundredth of a degree, with the
// principal point moved to make up for it, fits the same boards as well. What one camera sees is therefore
// compared with what the other sees after the rotation that brings the two sets of rays closest, as mrcal
// does ("Differencing", D. Kogan, mrcal's documentation); what is left is what no turning of the camera can
// take away.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

struct CameraDifferenceOptions {
  double diameter_m = 0.070;  ///< of the ball
  double range_m = 1.0;       ///< from the camera to the ball's centre
  int columns = 25;           ///< places across the picture, from border to border; rows by its shape
  std::uint64_t seed = 0;     ///< of the draws that `chance` comes from

  /// InputError for a ball that is not finite and positive or that the camera is in, and for fewer than 3 or
  /// more than 200 columns.
  void validate() const;
};

/// What the two cameras make of one place of the picture.
struct DifferencePlace {
  Eigen::Vector2d pixel_px{0, 0};
  /// Where the second camera sees what the first sees at this pixel, minus the pixel. Nothing where one of
  /// them has no ray.
  std::optional<Eigen::Vector2d> shift_px;
  /// A ball at `range_m` whose outline the first camera sees around this pixel: its centre as the second
  /// reads it minus as the first does (m, the second's camera frame). Nothing where the ball is not wholly in
  /// the picture.
  std::optional<Eigen::Vector3d> ball_m;
  /// Standard deviation of `ball_m` (root of its covariance's trace, m) by the cameras' own uncertainties.
  std::optional<double> ball_sigma_m;
};

/// How large the differences are over the picture.
struct DifferenceSpread {
  double median = 0, rms = 0, max = 0;
};

struct CameraDifference {
  Eigen::Matrix3d R_BA = Eigen::Matrix3d::Identity();  ///< turns the first's rays onto the second's
  Eigen::Vector3d rotation_rad{0, 0, 0};               ///< the same as rotation vector
  int columns = 0, rows = 0;
  std::vector<DifferencePlace> places;  ///< row by row
  DifferenceSpread shift_px, ball_m;
  std::optional<double> ball_sigma_rms_m;  ///< what is to be expected of ball_m.rms
  std::optional<double> sigmas_rms;        ///< RMS of the balls' differences, each over its own sigma
  /// How often two calibrations of one camera, with these uncertainties and independent errors, would give as
  /// large a sigmas_rms; where both uncertainties are known.
  std::optional<double> chance;
};

/// Compares two cameras of one picture size. The rotation (Wahba's problem, solved by singular values:
/// Markley, 1988) is that of most of the picture: places where the two drift apart count little. Covariances
/// (of the parameters, in parameter_names' order) may be empty: not known. Throws InputError for different
/// picture sizes, and where the ball is nowhere wholly in the picture; Refusal where the two have rays for
/// fewer than three places in common.
CameraDifference compare_cameras(const Camera& a, const Eigen::MatrixXd& covariance_a, const Camera& b,
                                 const Eigen::MatrixXd& covariance_b,
                                 const CameraDifferenceOptions& options = {});

}  // namespace ballservo
