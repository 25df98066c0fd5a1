// Chessboard corners where the edges cross, to some thousandths of a pixel in a clean picture.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace ballservo {

/// Points of a board as a picture shows them (px), row by row.
template <class Point>
struct PointGrid {
  int columns = 0, rows = 0;
  std::vector<Point> points;

  const Point& at(int row, int column) const {
    return points[static_cast<std::size_t>(row * columns + column)];
  }
};
/// A chessboard's inner corners.
using CornerGrid = PointGrid<Eigen::Vector2d>;

/// Each corner again, from corners that are right to a small part of their spacing: the crossing of the model
///     I = mean + contrast erf(d1 / (sqrt(2) sigma1)) erf(d2 / (sqrt(2) sigma2)) + gradient . (u - crossing),
/// averaged over each pixel's area, that fits the picture's own pixels best (least squares, Levenberg and
/// Marquardt). d1 and d2 are the distances (px) to two curves through the crossing; everything is free but
/// the curves' curvature, which is that of the grid's rows and columns there. The window is a share of the
/// board's squares as the picture shows them.
///
/// A fit to gradients (cornerSubPix) moves by hundredths of a pixel with perspective, distortion and window,
/// which a calibration carries to the picture's rim; this one's model holds them.
///
/// Nothing for a corner of whose window the picture shows too little, or about which there is no such
/// crossing. `gray`: 8-bit, one channel. `grid`: at least 3 by 3.
std::vector<std::optional<Eigen::Vector2d>> refine_corners(const cv::Mat& gray, const CornerGrid& grid);

}  // namespace ballservo
