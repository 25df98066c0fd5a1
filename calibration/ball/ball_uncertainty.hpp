// What the uncertainty of a calibration means where it counts: at the ball.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// What a camera's own uncertainty does to the ball positions that are read through it.
class CameraUncertainty {
 public:
  /// `covariance` is of the camera's parameters (see CameraCovariance). Cameras changed along the
  /// covariance's own axes are made once; where a parameter is so uncertain that a twentieth of its sigma
  /// leaves what is valid, no covariance is given.
  CameraUncertainty(const Camera& camera, const Eigen::MatrixXd& covariance);

  /// The covariance of a ball's centre (m^2, camera frame) that it causes: the ball's outline as the camera
  /// sees it, read again with changed parameters, by central differences. Nothing where the outline cannot be
  /// read.
  std::optional<Eigen::Matrix3d> ball_covariance(const Eigen::Vector3d& p_C, double radius_m) const;

 private:
  Camera camera_;
  std::vector<std::pair<Camera, Camera>> changed_;  // up and down along each axis
  bool valid_ = true;
};

/// The standard deviation of a ball's 3-D centre (mm, square root of the covariance's trace) that the camera
/// parameters' covariance causes, over the picture.
struct BallSigmaMap {
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> places_px;       ///< where the ball's centre is seen, row by row
  std::vector<std::optional<double>> sigma_mm;  ///< nothing where not the whole ball is in the picture

  std::optional<double> worst_mm() const;
};

/// A map of `columns` by `rows` places from corner to corner of the picture, for a ball at one distance.
/// Nothing where the uncertainty is too large to be pushed through the camera.
std::optional<BallSigmaMap> ball_sigma_map(const Camera& camera, const Eigen::MatrixXd& covariance,
                                           double diameter_m, double range_m, int columns = 21,
                                           int rows = 15);

/// The worst of that map for a ball of 70 mm at 1 m; where no place shows that ball whole (a long lens), in
/// the picture's middle. Nothing where no such ball can be seen.
std::optional<double> ball_sigma_mm(const Camera& camera, const Eigen::MatrixXd& covariance,
                                    double diameter_m = 0.070, double range_m = 1.0);

}  // namespace ballservo
