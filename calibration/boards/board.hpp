// Flat calibration boards: what is on them and where.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace ballservo {

enum class BoardPattern { chessboard, circles, acircles };

/// Board frame: x along the rows, y down the columns, z into the board; the first point is the origin.
struct Board {
  BoardPattern pattern = BoardPattern::chessboard;
  int columns = 0, rows = 0;  ///< inner corners, or circle centres, of a row and of a column
  double square_m = 0;        ///< between neighbours; in an asymmetric grid between a row and the next

  /// All points, row by row, as OpenCV's detectors order them.
  std::vector<Eigen::Vector3d> points() const;
};

/// Points of a board as one picture shows them: all of them, or those of a part that is seen whole.
struct BoardView {
  std::string name;                         ///< of the picture, for messages
  std::vector<Eigen::Vector3d> points_m;    ///< in the board frame, z = 0
  std::vector<Eigen::Vector2d> corners_px;  ///< where they are found, as many

  std::size_t size() const { return corners_px.size(); }
};

/// The mean distance (px) between where two pictures show the same points, in the order in which it is less:
/// of a symmetric board the finder may begin at the other end. Infinite where they have no point in common.
double mean_motion_px(const BoardView& a, const BoardView& b);

/// "chessboard:9x6", "circles:6x6", "acircles:4x11" with the square's side in metres. InputError naming every
/// fault: an unknown pattern, fewer than 2 or more than 100 points a side (chessboards: 3, and OpenCV's
/// finder wants more than 2), a side that is not finite and above 0.
Board parse_board(const std::string& text, double square_m);

}  // namespace ballservo
