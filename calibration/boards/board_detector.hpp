// Finds a calibration board in a picture.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>

#include "calibration/boards/board.hpp"

namespace ballservo {

struct BoardFinding {
  std::optional<BoardView> view;
  std::string reason;  ///< in words, why there is none; empty where there is one
  /// Points of a row and column of the chessboard that is seen, whatever was asked for; the larger first.
  /// (OpenCV's finder of a given size is content with a part of a larger board.)
  std::optional<std::pair<int, int>> seen;
};

/// The board's points in a picture (8-bit, 1 or 3 channels), or of the part of a chessboard that is seen
/// whole: at least a third of it. Which part does not matter to a calibration, whose poses are free, so a
/// part is placed at the board frame's origin. Both of OpenCV's chessboard finders are tried, at several
/// scales.
///
/// Chessboard corners are refined to where the edges around them cross: first roughly (cornerSubPix, in a
/// window whose half is a third of the smallest distance of corners in this picture), then with a model of
/// the crossing (corner_refinement.hpp). Corners so near the border that their window is cut off are left
/// out.
BoardFinding find_board(const cv::Mat& picture, const Board& board);

}  // namespace ballservo
