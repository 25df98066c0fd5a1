// Whether pictures of a board come from one camera or from two.
#pragma once

#include <optional>
#include <vector>

#include "calibration/boards/board_adjustment.hpp"

namespace ballservo {

/// Two cameras that explain the boards where one does not.
struct CameraMixture {
  std::vector<bool> second;  ///< of each view: taken with the second camera
  CameraParameters first_camera, second_camera;
  double rms_together_px = 0, rms_apart_px = 0;
};

/// Splits the views into two groups, each with a camera of its own, going back and forth between fitting the
/// cameras and giving each view to the one that explains it better, from several starts. A mixture is
/// reported where each group has four views, the error falls clearly, that of each view under its camera
/// as fitted without it, and nearly every view is explained clearly worse by the other camera.
/// What a bend of the board explains counts for no second camera.
/// Nothing for fewer than eight.
std::optional<CameraMixture> find_mixed_cameras(const std::vector<BoardView>& views,
                                                const BoardAdjustment& flat);

}  // namespace ballservo
