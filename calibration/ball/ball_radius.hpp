// A ball's radius from pictures of it: at known distances, or touching a plane that a board gives.
//
// A picture gives the ball's centre in units of its radius: c = C / R, with |c| = 1 / sin(alpha). A known
// distance D = |C| makes R = D / |c|. A plane n.x + e = 0 (n towards the camera, e > 0 the camera's height
// over it) that the ball touches from the camera's side, n.C + e = R, makes R = e / (1 - n.c).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/boards/board.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

/// A ball as a picture shows it: its centre in radii (camera frame), with the fit's own covariance.
struct UnitBall {
  Eigen::Vector3d center{0, 0, 0};
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// The part of the outline's error that pictures share (px, standard deviation): light and background shift
  /// the edges of one scene alike. What the cone fit allows for it, contained in the covariance.
  double common_sigma_px = 0.025;
};

/// What one picture says of the radius.
struct RadiusReading {
  double radius_m = 0;
  double sigma_m = 0;   ///< by the outline's error and the distance's or the board's corners'
  double common_m = 0;  ///< of it, what the outlines' common error does
  /// By how much it changes per standard deviation along each axis of the camera's covariance (m): errors
  /// that all pictures share.
  Eigen::VectorXd by_camera_m;
};

/// Reads radii through one camera, whose parameters' covariance may be empty (not known).
class RadiusReader {
 public:
  RadiusReader(const Camera& camera, const Eigen::MatrixXd& covariance);

  /// From the distance (m) of the ball's centre from the camera's centre of projection.
  std::optional<RadiusReading> at_distance(const UnitBall& ball, double distance_m, double sigma_m) const;
  /// From a ball that touches a plane `depth_m` behind the board's face (0: the face itself). Nothing where
  /// the board has no pose, or the ball lies behind the plane.
  std::optional<RadiusReading> on_board(const UnitBall& ball, const BoardView& board, double depth_m) const;

 private:
  template <typename Read>
  std::optional<Eigen::VectorXd> by_camera(const UnitBall& ball, const Read& read) const;

  template <typename Read>
  double by_outline(const UnitBall& ball, const Read& read) const;

  Camera camera_;
  CameraUncertainty uncertainty_;
};

struct RadiusEstimate {
  double radius_m = 0, sigma_m = 0;
  std::vector<bool> used;
  double chi2_per_dof = 0;  ///< of the used pictures about the estimate; above 1 it widens sigma_m; 0 for one
};

/// The radius that the pictures agree on: the best linear unbiased one (generalised least squares) of those
/// within four standard deviations (or 1 % of the radius, if that is more) of their median. Throws Refusal
/// with everybody's figures where more than a quarter of them are not; `names` are the pictures'.
RadiusEstimate combine_radii(const std::vector<RadiusReading>& readings,
                             const std::vector<std::string>& names);

}  // namespace ballservo
