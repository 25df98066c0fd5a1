// What the uncertainty of a calibration means where it counts: at the ball.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// Of a ball's outline, from which its place is computed.
inline constexpr int outline_points = 24;

/// Columns l_i with sum l_i l_i' = covariance; also for a matrix whose entries differ by orders of magnitude.
Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance);

/// What a camera's own uncertainty does to what is read through it.
class CameraUncertainty {
 public:
  /// `covariance` is of the camera's parameters (see parameter_names); empty: not known. Cameras changed
  /// along the covariance's own axes are made once.
  CameraUncertainty(const Camera& camera, const Eigen::MatrixXd& covariance);

  /// False where a parameter is so uncertain that a twentieth of its sigma leaves what is valid: then no
  /// derivatives are given.
  bool is_valid() const { return valid_; }

  /// The derivatives of what `read(camera)` makes of a camera (an optional) per standard deviation along each
  /// axis of the covariance, by central differences. Nothing where it makes nothing of one of them.
  template <class Value, class Read>
  std::optional<std::vector<Value>> derivatives(const Read& read) const {
    if (!valid_) return std::nullopt;
    std::vector<Value> result;
    for (const auto& [above, below] : changed_) {
      const auto high = read(above), low = read(below);
      if (!high || !low) return std::nullopt;
      result.push_back((*high - *low) / (2 * step_sigmas));
    }
    return result;
  }

  /// The covariance of a ball's centre (m^2, camera frame) that it causes: the ball's outline as the camera
  /// sees it, read again with changed parameters. Nothing where the outline cannot be read.
  std::optional<Eigen::Matrix3d> ball_covariance(const Eigen::Vector3d& p_C, double radius_m) const;
  /// The square root of its trace.
  std::optional<double> ball_sigma_mm(const Eigen::Vector3d& p_C, double radius_m) const;

 private:
  static constexpr double step_sigmas = 0.05;  // small against one sigma, large against rounding

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
std::optional<double> ball_sigma_mm(const Camera& camera, const Eigen::MatrixXd& covariance);

}  // namespace ballservo
