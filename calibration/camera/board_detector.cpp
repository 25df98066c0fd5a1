#include "calibration/camera/board_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace ballservo {
namespace {

/// The smallest distance between neighbours in a row or column (px).
float smallest_spacing(const std::vector<cv::Point2f>& points, const Board& board) {
  float smallest = std::numeric_limits<float>::infinity();
  const auto at = [&](int row, int column) {
    return points[static_cast<std::size_t>(row * board.columns + column)];
  };
  const auto consider = [&](cv::Point2f a, cv::Point2f b) {
    smallest = std::min(smallest, std::hypot(a.x - b.x, a.y - b.y));
  };
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      if (column > 0) consider(at(row, column), at(row, column - 1));
      if (row > 0) consider(at(row, column), at(row - 1, column));
    }
  }
  return smallest;
}

bool find_chessboard(const cv::Mat& gray, const Board& board, std::vector<cv::Point2f>& points) {
  const cv::Size size(board.columns, board.rows);
  if (!cv::findChessboardCorners(gray, size, points,
                                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE) &&
      !cv::findChessboardCornersSB(gray, size, points,
                                   cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE))
    return false;
  constexpr double window_share = 0.3;
  const int half = std::max(2, static_cast<int>(std::lround(window_share * smallest_spacing(points, board))));
  cv::cornerSubPix(gray, points, cv::Size(half, half), cv::Size(-1, -1),
                   cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-4));
  // A window that the picture's border cuts off pulls its corner inwards.
  return std::all_of(points.begin(), points.end(), [&](const cv::Point2f& point) {
    return point.x >= half && point.y >= half && point.x <= gray.cols - 1 - half &&
           point.y <= gray.rows - 1 - half;
  });
}

}  // namespace

std::optional<std::vector<Eigen::Vector2d>> find_board(const cv::Mat& bgr, const Board& board) {
  cv::Mat gray;
  if (bgr.channels() == 3)
    cv::cvtColor(bgr, gray, cv::COLOR_BGR2GRAY);
  else
    gray = bgr;
  // OpenCV's finders want some pixels to work on, and throw where there are none.
  if (gray.cols < 16 || gray.rows < 16) return std::nullopt;
  std::vector<cv::Point2f> points;
  const bool found =
      board.pattern == BoardPattern::chessboard
          ? find_chessboard(gray, board, points)
          : cv::findCirclesGrid(gray, cv::Size(board.columns, board.rows), points,
                                board.pattern == BoardPattern::circles ? cv::CALIB_CB_SYMMETRIC_GRID
                                                                       : cv::CALIB_CB_ASYMMETRIC_GRID);
  if (!found || points.size() != static_cast<std::size_t>(board.columns * board.rows)) return std::nullopt;
  std::vector<Eigen::Vector2d> result;
  for (const cv::Point2f& point : points) {
    result.emplace_back(point.x, point.y);
    if (!result.back().allFinite()) return std::nullopt;
  }
  return result;
}

}  // namespace ballservo
