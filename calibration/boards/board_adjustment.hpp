// The least-squares problem of calibration: one camera, several poses of one board, residuals in pixels.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/boards/board.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

/// X_CB as rotation vector (rad) and translation (m).
using BoardPose = Eigen::Matrix<double, 6, 1>;

/// The board's z axis in the camera frame.
Eigen::Vector3d board_normal(const BoardPose& X_CB);

/// What is known of each corner of one view, in the view's order.
struct CornerResiduals {
  std::vector<Eigen::Vector2d> residuals_px;  ///< projected minus found
  std::vector<bool> set_aside;                ///< held for wrong, without a say in the solution

  double rms_px() const;  ///< over the corners that are not set aside; NaN: none
};

struct BoardAdjustment {
  CameraParameters parameters;
  std::vector<BoardPose> poses;
  std::vector<CornerResiduals> corners;  ///< of each view
  double rms_px = 0;  ///< sqrt of the mean squared 2-D distance over the corners not set aside
  bool converged = false;
};

/// Some of the views, with their poses.
struct BoardGroup {
  std::vector<BoardView> views;
  std::vector<BoardPose> poses;
};
/// Those whose index is `wanted`.
template <class Wanted>
BoardGroup board_group(const std::vector<BoardView>& views, const BoardAdjustment& all,
                       const Wanted& wanted) {
  BoardGroup group;
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (!wanted(v)) continue;
    group.views.push_back(views[v]);
    group.poses.push_back(all.poses[v]);
  }
  return group;
}

enum class CornerLoss {
  squares,  ///< every corner counts with its squared distance
  robust    ///< corners beyond six standard deviations of their view are set aside, found from a Huber fit
};

/// Minimises the distances in pixels over the camera's parameters and the poses. Levenberg and Marquardt
/// (Ceres), one thread. Nothing if the start does not project.
std::optional<BoardAdjustment> adjust_boards(const std::vector<BoardView>& views,
                                             const CameraParameters& start,
                                             const std::vector<BoardPose>& start_poses,
                                             CornerLoss loss = CornerLoss::squares);

/// The same over the poses alone, for a camera that stays as it is.
std::optional<BoardAdjustment> adjust_poses(const std::vector<BoardView>& views,
                                            const CameraParameters& camera,
                                            const std::vector<BoardPose>& start_poses);

/// The views without the corners that an adjustment set aside: a wrong corner is no test of a camera.
std::vector<BoardView> believed_corners(const std::vector<BoardView>& views,
                                        const BoardAdjustment& adjustment);

/// J'J (1/px^2) of the residuals of one view by its pose.
Eigen::Matrix<double, 6, 6> pose_information(const BoardView& view, const BoardAdjustment& adjustment,
                                             std::size_t index);

/// Each board's pose under a given camera, from the rays of its points (planar homography, then OpenCV's
/// iterative solvePnP on the plane Z = 1); nothing where one has none.
std::optional<std::vector<BoardPose>> board_poses(const std::vector<BoardView>& views,
                                                  const CameraParameters& camera);

/// How well boards determine a camera.
struct BoardCovariance {
  Eigen::MatrixXd parameters;  ///< covariance, in parameter_names' order
  /// The same were every corner's error its own: what the boards' places alone determine.
  Eigen::MatrixXd of_independent_corners;
  double noise_px = 0;  ///< standard deviation of a corner's coordinate, from the residuals themselves
  /// Correlation of the focal length fx with the boards' mean distance, -1 to 1: near 1 the pictures tell
  /// only their ratio.
  double focal_distance_correlation = 0;
};

/// The corners of one board err together (focus, a rolling shutter, what the lens model leaves): so the
/// covariance is that of the fits that leave out one board each, every one a Gauss-Newton step from the fit
/// of all (the jackknife by clusters; MacKinnon, Nielsen & Webb, "Cluster-robust inference", 2023, CV3), and
/// in no direction less than that of independent corners: the inverse of the normal matrix J'J with the poses
/// eliminated (Schur complement), times the residuals' variance with the degrees of freedom counted. An error
/// that all boards share, such as one bent board's, it cannot tell. Corners set aside have no part. A
/// direction that the boards leave open gets an enormous variance. Nothing where a parameter has no influence
/// at all.
std::optional<BoardCovariance> board_covariance(const std::vector<BoardView>& views,
                                                const BoardAdjustment& adjustment);

}  // namespace ballservo
