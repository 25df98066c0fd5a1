#include "calibration/boards/board_calibration.hpp"

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/boards/calibration_checks.hpp"

namespace ballservo {
BoardCalibration calibrate_from_boards(ImageSize size, const std::vector<BoardView>& views,
                                       const std::vector<LensModel>& models) {
  require_enough_views(views);
  const std::vector<LensCandidate> candidates = lens_candidates(views, size, models);
  if (candidates.empty())
    throw Refusal("No camera fits these boards. Do rows and columns agree with the board?");
  const std::size_t chosen = choose_lens(candidates);
  const BoardAdjustment& adjustment = candidates[chosen].adjustment;
  // Parallel boards first: what they give is absurd in any way it likes.
  BoardCovariance covariance = require_focal_length(views, adjustment);
  // What was set aside as wrong says nothing of the camera, and covers nothing.
  const std::vector<BoardView> believed = believed_corners(views, adjustment);
  BoardCalibration result{require_sensible_camera(believed, adjustment), std::move(covariance)};
  result.structure_px = residual_structure_px(views, adjustment);
  const std::string misfit = lens_misfit(views, candidates, adjustment, result.structure_px);
  if (!misfit.empty() && models.size() > 1) throw Refusal(misfit);
  // A lens that fits nothing fits two halves of the pictures better than all of them.
  if (misfit.empty()) require_one_camera(views, adjustment);
  result.rms_px = adjustment.rms_px;
  result.held_out_rms_px = candidates[chosen].held_out_rms_px();
  result.coverage = picture_coverage(believed, size);
  result.ball_sigma_mm = ball_sigma_mm(result.camera, result.covariance.parameters);
  result.covered_ball_sigma_mm = covered_ball_sigma_mm(believed, result);
  result.corners = adjustment.corners;
  result.poses = adjustment.poses;
  result.trials = candidates;
  result.warnings = calibration_warnings(views, believed, result);
  if (!misfit.empty()) result.warnings.insert(result.warnings.begin(), misfit);
  return result;
}

}  // namespace ballservo
