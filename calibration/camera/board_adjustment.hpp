// The least-squares problem of calibration: one camera, several poses of one board, residuals in pixels.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"

namespace ballservo {

/// The board's points as one picture shows them.
using BoardView = std::vector<Eigen::Vector2d>;  // px, in the order of the board's points

/// X_CB as rotation vector (rad) and translation (m).
using BoardPose = Eigen::Matrix<double, 6, 1>;

struct BoardAdjustment {
  CameraParameters parameters;
  std::vector<BoardPose> poses;
  std::vector<BoardView> residuals_px;  ///< projected minus found
  double rms_px = 0;                    ///< sqrt of the mean squared 2-D distance, as OpenCV reports it
  bool converged = false;
};

/// Minimises the squared distances in pixels over the poses, and over the camera's parameters too unless
/// `fixed_camera`. Levenberg and Marquardt (Ceres), one thread. Nothing if the start does not project.
std::optional<BoardAdjustment> adjust_boards(const std::vector<Eigen::Vector3d>& board_points,
                                             const std::vector<BoardView>& views,
                                             const CameraParameters& start,
                                             const std::vector<BoardPose>& start_poses, bool fixed_camera);

/// Each board's pose under a given camera, from the rays of its points (planar homography, then OpenCV's
/// iterative solvePnP on the plane Z = 1); nothing where one has none.
std::optional<std::vector<BoardPose>> board_poses(const std::vector<Eigen::Vector3d>& board_points,
                                                  const std::vector<BoardView>& views,
                                                  const CameraParameters& camera);

/// Information (inverse covariance) of the camera's parameters for residuals of 1 px a coordinate, the poses
/// eliminated: sum of J_c' J_c - J_c' J_p (J_p' J_p)^-1 J_p' J_c over the boards.
Eigen::MatrixXd camera_information(const std::vector<Eigen::Vector3d>& board_points,
                                   const BoardAdjustment& adjustment);

}  // namespace ballservo
