// When a calibration can't be trusted: each check refuses with its reason and what to photograph next.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibration/boards/board_adjustment.hpp"
#include "calibration/boards/lens_choice.hpp"

namespace ballservo {

struct BoardCalibration;

/// Refusal for fewer than three views.
void require_enough_views(const std::vector<BoardView>& views);

/// The covariance of the parameters. Refusal where the boards do not determine the focal length to 2 %,
/// saying whether the angles, the distances or both are too much alike.
BoardCovariance require_focal_length(const std::vector<BoardView>& views, const BoardAdjustment& adjustment);

/// The camera. Refusal for one that no lens has: a principal point outside the picture, focal lengths that
/// differ by a factor of two, a lens that folds inside the boards' corners.
Camera require_sensible_camera(const std::vector<BoardView>& views, const BoardAdjustment& adjustment);

/// Refusal where two cameras explain the pictures and one does not (mixed_cameras.hpp), naming the pictures
/// of each.
void require_one_camera(const std::vector<BoardView>& views, const BoardAdjustment& adjustment);

/// Where the lens model cannot explain the pictures, in words: one that was not tried leaves much less of the
/// error, or most of it depends on the place in the picture (`structure_px`). Empty
/// where nothing is wrong.
std::string lens_misfit(const std::vector<BoardView>& views, const std::vector<LensCandidate>& tried,
                        const BoardAdjustment& adjustment, std::optional<double> structure_px);

/// What a user should look at, in words. `believed`: the views without the corners that were set aside.
std::vector<std::string> calibration_warnings(const std::vector<BoardView>& views,
                                              const std::vector<BoardView>& believed,
                                              const BoardCalibration& calibration);

/// The median of ball_uncertainty.hpp's map over the places that have a corner of a board within a twentieth
/// of the picture's width: what the calibration is worth where it does not extrapolate.
std::optional<double> covered_ball_sigma_mm(const std::vector<BoardView>& views,
                                            const BoardCalibration& calibration);

/// Part of the picture's cells (8 by 6) in which a corner lies, 0 to 1.
double picture_coverage(const std::vector<BoardView>& views, ImageSize size);

/// The part of the residuals (px, RMS of the 2-D vectors) that depends on the place in the picture: the mean
/// in each cell of a grid over it, averaged first over each board's corners there, less what chance alone
/// leaves (the boards' scatter tells). A camera whose model is right has 0, or little more. Nothing where no
/// cell is seen by three boards.
std::optional<double> residual_structure_px(const std::vector<BoardView>& views,
                                            const BoardAdjustment& adjustment);

}  // namespace ballservo
