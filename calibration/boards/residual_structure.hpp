// What a calibration's residuals say beyond noise: that the lens model does not suffice.
#pragma once

#include <optional>
#include <vector>

#include "calibration/boards/board_adjustment.hpp"

namespace ballservo {

/// The part of the residuals (px, RMS of the 2-D vectors) that depends on the place in the picture: the mean
/// in each cell of a grid over it, averaged first over each board's corners there, less what chance alone
/// leaves (the boards' scatter tells). A camera whose model is right has 0, or little more. Nothing where no
/// cell is seen by three boards.
std::optional<double> residual_structure_px(const std::vector<BoardView>& views,
                                            const BoardAdjustment& adjustment);

}  // namespace ballservo
