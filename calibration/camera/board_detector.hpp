// Finds a calibration board in a picture.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/board.hpp"

namespace ballservo {

/// The board's points in the picture (px, in the order of Board::points up to the board's own symmetry);
/// nothing where the whole board is not seen, or a
/// chessboard's corner is so near the border that its window is cut off. `bgr`: 8-bit, 1 or 3 channels.
///
/// Chessboard corners are refined where the edges around them meet (cornerSubPix), in a window whose half is
/// 0.3 of the smallest distance of corners in this picture: a larger one takes in the neighbours' edges (11
/// px on OpenCV's own pictures doubles the error), a fixed one fits no other board.
std::optional<std::vector<Eigen::Vector2d>> find_board(const cv::Mat& bgr, const Board& board);

}  // namespace ballservo
