#include "app/live/board_outline.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace ballservo {
namespace {

constexpr double tilt_rad = 0.52;  // 30 degrees
constexpr double edge = 0.02;      // of the picture's width, that stays free
constexpr int rounds = 10;

/// The outermost points from the middle between them.
std::array<Eigen::Vector3d, 4> corners_of(const Board& board) {
  Eigen::Vector3d high = Eigen::Vector3d::Zero();  // the first point is the origin
  for (const Eigen::Vector3d& point : board.points()) high = high.cwiseMax(point);
  const double x = high.x() / 2, y = high.y() / 2;
  return {{{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}}};
}

}  // namespace

std::vector<Eigen::Vector2d> outline_of(const AskedBoard& asked, const Board& board, const Camera& camera) {
  static const std::array<Eigen::Vector3d, 4> axes{{{0, 1, 0}, {1, 0, 0}, {0, -1, 0}, {-1, 0, 0}}};
  const Eigen::Matrix3d R_CB = Eigen::AngleAxisd(tilt_rad, axes[asked.side]).toRotationMatrix();
  const std::array<Eigen::Vector3d, 4> corners = corners_of(board);
  const Eigen::Array2d size(camera.size().width_px, camera.size().height_px);
  const double free_px = edge * size.x();
  double range_m = 5 * corners[2].norm();
  Eigen::Array2d place_px = asked.place_px;
  std::vector<Eigen::Vector2d> outline;
  for (int round = 0; round < rounds; ++round) {  // nearer or farther, and into the picture
    const auto ray = camera.unproject(place_px.matrix());
    if (!ray) return {};
    outline.clear();
    for (const Eigen::Vector3d& corner : corners) {
      const auto seen = camera.project(range_m * *ray + R_CB * corner);
      if (!seen) return {};
      outline.push_back(*seen);
    }
    Eigen::Array2d low = outline.front(), high = low;
    for (const Eigen::Vector2d& corner : outline)
      low = low.min(corner.array()), high = high.max(corner.array());
    range_m *= ((high - low) / size).maxCoeff() / asked.span;
    place_px += (free_px - low).max(0) - (high - (size - 1 - free_px)).max(0);
  }
  return outline;
}

}  // namespace ballservo
