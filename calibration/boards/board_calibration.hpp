// A camera from pictures of a flat board, and how far it can be trusted.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calibration/boards/board.hpp"
#include "calibration/boards/lens_choice.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

struct BoardCalibration {
  Camera camera;
  BoardCovariance covariance;
  double rms_px = 0;           ///< sqrt of the mean squared 2-D distance over all points
  double held_out_rms_px = 0;  ///< the same on boards whose camera comes from the other boards; NaN: none
  double coverage = 0;         ///< part of the picture's cells (8 by 6) in which a corner lies
  std::optional<double> ball_sigma_mm{};          ///< see ball_uncertainty.hpp
  std::optional<double> covered_ball_sigma_mm{};  ///< the same, the median where boards were
  std::optional<double> structure_px{};           ///< see calibration_checks.hpp
  std::vector<CornerResiduals> corners{};         ///< of each view
  std::vector<BoardPose> poses{};                 ///< X_CB of each view
  std::vector<LensCandidate> trials{};            ///< the models tried, simplest first
  std::vector<std::string> warnings{};            ///< in words, of what a user should look at
};

/// Calibrates from at least three views. One of `models` is taken even where it fits badly; of several the
/// simplest whose held-out error lies within one standard error of the best one's. The final solve is the
/// same for all models: distances in pixels, each corner with the same weight, corners that are plainly wrong
/// set aside. Throws Refusal, in words that say what to photograph, for what calibration_checks.hpp lists.
BoardCalibration calibrate_from_boards(ImageSize size, const std::vector<BoardView>& views,
                                       const std::vector<LensModel>& models = {LensModel::brown});

}  // namespace ballservo
