// What a board looks like where it is asked for.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "calibration/boards/board.hpp"
#include "calibration/camera/camera.hpp"

namespace ballservo {

/// A board that somebody is asked to hold.
struct AskedBoard {
  Eigen::Vector2d place_px{0, 0};  ///< of its middle, as far as the board is in the picture there
  std::size_t side = 0;            ///< that is tilted towards the camera: right, upper, left, lower
  double span = 0.35;              ///< of the picture's width or height, whichever is more
};

/// Where its four outermost points are seen (px), in turn from the upper left; none where the camera sees no
/// such board.
std::vector<Eigen::Vector2d> outline_of(const AskedBoard& asked, const Board& board, const Camera& camera);

}  // namespace ballservo
