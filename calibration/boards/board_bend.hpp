// A board that is not flat.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/boards/board_adjustment.hpp"

namespace ballservo {

/// The boards bent as one board is, and what then fits them.
struct BentBoards {
  Eigen::Vector3d bend_per_m{0, 0, 0};  ///< z = b0 x^2 + b1 x y + b2 y^2 (m) about the board's middle
  std::vector<BoardView> views;         ///< with that z
  BoardAdjustment adjustment;
};

/// The quadratic bend, the same in all views, that lets one camera explain them best: Gauss and Newton over
/// the bend, with camera and poses solved anew for each (variable projection: Golub and Pereyra, 1973).
/// Nothing where a solution fails.
std::optional<BentBoards> bend_boards(const std::vector<BoardView>& views, const BoardAdjustment& flat);

}  // namespace ballservo
