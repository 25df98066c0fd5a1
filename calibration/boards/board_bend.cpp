#include "calibration/boards/board_bend.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace ballservo {
namespace {

Eigen::Vector2d middle_m(const std::vector<BoardView>& views) {
  Eigen::Vector2d low(0, 0), high(0, 0);
  for (const BoardView& view : views) {
    for (const Eigen::Vector3d& point : view.points_m) {
      low = low.cwiseMin(point.head<2>());
      high = high.cwiseMax(point.head<2>());
    }
  }
  return 0.5 * (low + high);
}

std::optional<BentBoards> bent(const std::vector<BoardView>& views, const Eigen::Vector3d& bend_per_m,
                               const BoardAdjustment& start) {
  std::vector<BoardView> raised = views;
  const Eigen::Vector2d middle = middle_m(views);
  for (BoardView& view : raised) {
    for (Eigen::Vector3d& point : view.points_m) {
      const Eigen::Vector2d p = point.head<2>() - middle;
      point.z() = bend_per_m.dot(Eigen::Vector3d(p.x() * p.x(), p.x() * p.y(), p.y() * p.y()));
    }
  }
  auto adjustment = adjust_boards(raised, start.parameters, start.poses);
  if (!adjustment) return std::nullopt;
  return BentBoards{bend_per_m, std::move(raised), std::move(*adjustment)};
}

Eigen::VectorXd residuals_px(const BoardAdjustment& adjustment) {
  std::vector<double> all;
  for (const CornerResiduals& corners : adjustment.corners)
    for (const Eigen::Vector2d& residual : corners.residuals_px)
      all.insert(all.end(), {residual.x(), residual.y()});
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

}  // namespace

std::optional<BentBoards> bend_boards(const std::vector<BoardView>& views, const BoardAdjustment& flat) {
  constexpr int steps = 2;  // it is nearly linear
  constexpr double rise_of_width = 1e-3;
  // A trial's bend raises the board's rim by a thousandth of its half-width.
  const double half_width_m = middle_m(views).norm();
  if (!(half_width_m > 0)) return std::nullopt;
  const double trial_per_m = rise_of_width / half_width_m;
  auto best = bent(views, Eigen::Vector3d::Zero(), flat);
  for (int step = 0; best && step < steps; ++step) {
    const Eigen::VectorXd residuals = residuals_px(best->adjustment);
    Eigen::Matrix<double, Eigen::Dynamic, 3> by_bend(residuals.size(), 3);
    for (int i = 0; i < 3; ++i) {
      const auto tried =
          bent(views, best->bend_per_m + trial_per_m * Eigen::Vector3d::Unit(i), best->adjustment);
      if (!tried) return std::nullopt;
      by_bend.col(i) = (residuals_px(tried->adjustment) - residuals) / trial_per_m;
    }
    const Eigen::Matrix3d normal = by_bend.transpose() * by_bend;
    const Eigen::Vector3d change = -normal.ldlt().solve(by_bend.transpose() * residuals);
    if (!change.allFinite()) return best;
    auto next = bent(views, best->bend_per_m + change, best->adjustment);
    if (!next || next->adjustment.rms_px >= best->adjustment.rms_px) return best;
    best = std::move(next);
  }
  return best;
}

}  // namespace ballservo
