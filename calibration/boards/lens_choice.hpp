// Which lens model a set of boards asks for.
#pragma once

#include <optional>
#include <vector>

#include "calibration/boards/board_adjustment.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

/// A model fitted to boards, and how it does on boards that it has not seen.
struct LensCandidate {
  BoardAdjustment adjustment;
  /// Mean squared error (px^2) of each board under the camera that the other boards give (in four groups),
  /// its pose fitted; empty where some of the boards alone give no camera.
  std::vector<double> held_out_px2;

  /// Whether every corner of the picture has a ray, and the parameters are known well enough to tell what
  /// their uncertainty does to a ball: a choice takes no other while there is one.
  bool usable = false;

  LensModel model() const { return adjustment.parameters.model; }
  double held_out_rms_px() const;  ///< NaN where there is none
};

/// The camera of that model for these boards, wherever the optimiser has to start from; nothing where none
/// fits.
std::optional<BoardAdjustment> fit_lens(const std::vector<BoardView>& views, ImageSize size, LensModel model);

/// All models that can be fitted, the ones with fewer coefficients first.
std::vector<LensCandidate> lens_candidates(const std::vector<BoardView>& views, ImageSize size,
                                           std::vector<LensModel> models);

/// Index of the simplest candidate whose held-out error lies within one standard error of the best one's
/// (Breiman et al., Classification and Regression Trees, 1984); the candidates come simplest first. The
/// boards are the same for all, so what counts is the standard error of the differences board by board.
std::size_t choose_lens(const std::vector<LensCandidate>& candidates);

/// Whether every corner of the picture has a ray.
bool covers_picture(const CameraParameters& parameters);

}  // namespace ballservo
