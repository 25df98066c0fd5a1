#include "calibration/boards/residual_structure.hpp"

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr int cells_across = 8, cells_down = 6;
constexpr std::size_t least_boards = 3;  // in a cell, to tell a common error from the boards' own

using CellMeans =
    std::vector<std::vector<Eigen::Vector2d>>;  // of each cell, the mean of each board seen there

CellMeans cell_means(const std::vector<BoardView>& views, const BoardAdjustment& adjustment) {
  const ImageSize size = adjustment.parameters.size;
  CellMeans means(static_cast<std::size_t>(cells_across * cells_down));
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<Eigen::Vector2d> sums(means.size(), Eigen::Vector2d::Zero());
    std::vector<int> counts(means.size(), 0);
    for (std::size_t i = 0; i < views[v].size(); ++i) {
      if (adjustment.corners[v].set_aside[i]) continue;
      const Eigen::Vector2d& corner = views[v].corners_px[i];
      const int column =
          std::clamp(static_cast<int>(cells_across * corner.x() / size.width_px), 0, cells_across - 1);
      const int row =
          std::clamp(static_cast<int>(cells_down * corner.y() / size.height_px), 0, cells_down - 1);
      const auto cell = static_cast<std::size_t>(row * cells_across + column);
      sums[cell] += adjustment.corners[v].residuals_px[i];
      ++counts[cell];
    }
    for (std::size_t cell = 0; cell < means.size(); ++cell)
      if (counts[cell] > 0) means[cell].push_back(sums[cell] / counts[cell]);
  }
  return means;
}

}  // namespace

std::optional<double> residual_structure_px(const std::vector<BoardView>& views,
                                            const BoardAdjustment& adjustment) {
  double sum_px2 = 0;
  int cells = 0;
  for (const std::vector<Eigen::Vector2d>& boards : cell_means(views, adjustment)) {
    if (boards.size() < least_boards) continue;
    const auto count = static_cast<double>(boards.size());
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& board : boards) mean += board / count;
    double scatter_px2 = 0;
    for (const Eigen::Vector2d& board : boards) scatter_px2 += (board - mean).squaredNorm();
    sum_px2 += mean.squaredNorm() - scatter_px2 / (count - 1) / count;
    ++cells;
  }
  if (cells == 0) return std::nullopt;
  return std::sqrt(std::max(0.0, sum_px2 / cells));
}

}  // namespace ballservo
