// How well boards determine a camera: the covariance of its parameters.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/boards/board_adjustment.hpp"

namespace ballservo {

struct BoardCovariance {
  Eigen::MatrixXd parameters;  ///< covariance, in parameter_names' order
  double noise_px = 0;         ///< standard deviation of a corner's coordinate, from the residuals themselves
  /// Correlation of the focal length fx with the boards' mean distance, -1 to 1: near 1 the pictures tell
  /// only their ratio.
  double focal_distance_correlation = 0;
};

/// The inverse of the normal matrix J'J with the poses eliminated (Schur complement), times the residuals'
/// variance with the degrees of freedom counted; corners set aside have no part. A direction that the boards
/// leave open gets an enormous variance. Nothing where a parameter has no influence at all.
std::optional<BoardCovariance> board_covariance(const std::vector<BoardView>& views,
                                                const BoardAdjustment& adjustment);

}  // namespace ballservo
