#include "calibration/boards/mixed_cameras.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

constexpr int starts = 5, max_rounds = 8;
constexpr std::size_t least_group_views = 4;  // of each camera
// How much the boards' squared errors must fall, each under a camera fitted without it. In real sets of one
// camera of 8 to 20 pictures they fall by 1.1 at most, in those of two by 1.5.
constexpr double least_error_ratio = 1.3;
// Pictures that either camera explains about as well; where they are many, the cameras are made up.
constexpr double most_undecided = 0.1, clear_error_ratio = 1.5;
constexpr double floor_px2 = 0.05 * 0.05;  // below it no error tells anything: no finder is that good

/// The boards bent as one board is, and what then fits them.
struct BentBoards {
  Eigen::Vector3d bend_per_m{0, 0, 0};  ///< z = b0 x^2 + b1 x y + b2 y^2 (m) about the board's middle
  std::vector<BoardView> views;         ///< with that z
  BoardAdjustment adjustment;
};

Eigen::Vector2d middle_m(const std::vector<BoardView>& views) {
  Eigen::AlignedBox2d board(Eigen::Vector2d(0, 0));
  for (const BoardView& view : views)
    for (const Eigen::Vector3d& point : view.points_m) board.extend(point.head<2>());
  return board.center();
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

/// The quadratic bend, the same in all views, that lets one camera explain them best: Gauss and Newton over
/// the bend, with camera and poses solved anew for each (variable projection: Golub and Pereyra, 1973).
/// Nothing where a solution fails.
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

/// Squared error (px^2) of every view under one camera, its pose fitted.
std::optional<std::vector<double>> errors_px2(const std::vector<BoardView>& views,
                                              const BoardAdjustment& together,
                                              const CameraParameters& camera) {
  const auto fit = adjust_poses(views, camera, together.poses);
  if (!fit) return std::nullopt;
  std::vector<double> errors;
  for (const CornerResiduals& corners : fit->corners)
    errors.push_back(std::pow(corners.rms_px(), 2) * static_cast<double>(corners.residuals_px.size()));
  return errors;
}

struct Split {
  std::vector<bool> second;
  CameraParameters first_camera, second_camera;
  double error_px2 = 0;
  std::vector<double> errors_px2;        // of each view
  std::vector<double> other_errors_px2;  // under the other camera
};

std::optional<Split> improve(const std::vector<BoardView>& views, const BoardAdjustment& together,
                             std::vector<bool> second) {
  std::optional<Split> split;
  for (int round = 0; round < max_rounds; ++round) {
    const BoardGroup a = board_group(views, together, [&](std::size_t v) { return !second[v]; }),
                     b = board_group(views, together, [&](std::size_t v) { return second[v]; });
    if (a.views.size() < least_group_views || b.views.size() < least_group_views) return std::nullopt;
    const auto fit_a = adjust_boards(a.views, together.parameters, a.poses);
    const auto fit_b = adjust_boards(b.views, together.parameters, b.poses);
    if (!fit_a || !fit_b) return std::nullopt;
    const auto by_a = errors_px2(views, together, fit_a->parameters);
    const auto by_b = errors_px2(views, together, fit_b->parameters);
    if (!by_a || !by_b) return std::nullopt;
    split = Split{second, fit_a->parameters, fit_b->parameters, 0, {}, {}};
    std::vector<bool> better(views.size());
    for (std::size_t v = 0; v < views.size(); ++v) {
      better[v] = (*by_b)[v] < (*by_a)[v];
      split->errors_px2.push_back(second[v] ? (*by_b)[v] : (*by_a)[v]);
      split->other_errors_px2.push_back(second[v] ? (*by_a)[v] : (*by_b)[v]);
      split->error_px2 += split->errors_px2.back();
    }
    if (better == second) break;
    second = better;
  }
  return split;
}

/// Squared error (px^2) of every view under its group's camera as fitted without that view: four boards can
/// be explained by many a camera, but not a fifth.
std::optional<std::vector<double>> errors_without_view_px2(const std::vector<BoardView>& views,
                                                           const BoardAdjustment& together,
                                                           const Split& split) {
  std::vector<double> errors(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const BoardGroup others = board_group(
        views, together, [&](std::size_t w) { return w != v && split.second[w] == split.second[v]; });
    const auto fit =
        adjust_boards(others.views, split.second[v] ? split.second_camera : split.first_camera, others.poses);
    const auto by_others = fit ? errors_px2(views, together, fit->parameters) : std::nullopt;
    if (!by_others) return std::nullopt;
    errors[v] = (*by_others)[v];
  }
  return errors;
}

/// By how much the boards' squared errors fall, in their geometric mean: a few bad pictures are no camera.
double error_ratio(const std::vector<BoardView>& views, const BoardAdjustment& together,
                   const std::vector<double>& errors_px2) {
  double log_ratio = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double apart_px2 = errors_px2[v] / static_cast<double>(views[v].size());
    log_ratio += std::log((std::pow(together.corners[v].rms_px(), 2) + floor_px2) / (apart_px2 + floor_px2));
  }
  return std::exp(log_ratio / static_cast<double>(views.size()));
}

}  // namespace

std::optional<CameraMixture> find_mixed_cameras(const std::vector<BoardView>& all_views,
                                                const BoardAdjustment& flat) {
  if (all_views.size() < 2 * least_group_views) return std::nullopt;
  // A bent board is the commonest other reason why no one camera fits: what it explains is no second camera.
  const auto best_bent = bend_boards(believed_corners(all_views, flat), flat);
  if (!best_bent) return std::nullopt;
  const std::vector<BoardView>& views = best_bent->views;
  const BoardAdjustment& together = best_bent->adjustment;
  RandomEngine engine = random_stream(0, "mixed cameras");
  std::optional<Split> best;
  for (int start = 0; start < starts; ++start) {
    std::vector<bool> second(views.size());
    for (std::size_t v = 0; v < views.size(); ++v) second[v] = uniform(engine, 0, 1) < 0.5;
    if (start == 0)  // as pictures of two cameras most often come: one after the other
      for (std::size_t v = 0; v < views.size(); ++v) second[v] = v >= views.size() / 2;
    const auto split = improve(views, together, second);
    if (split && (!best || split->error_px2 < best->error_px2)) best = split;
  }
  if (!best) return std::nullopt;
  double corners = 0, undecided = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto points = static_cast<double>(views[v].size());
    corners += points;
    undecided += best->other_errors_px2[v] / points + floor_px2 <
                 clear_error_ratio * (best->errors_px2[v] / points + floor_px2);
  }
  if (undecided > most_undecided * static_cast<double>(views.size())) return std::nullopt;
  // Held out a view errs more than fitted: what the fit does not show need not be looked at.
  if (!(error_ratio(views, together, best->errors_px2) > least_error_ratio)) return std::nullopt;
  const auto held_out_px2 = errors_without_view_px2(views, together, *best);
  if (!held_out_px2 || !(error_ratio(views, together, *held_out_px2) > least_error_ratio))
    return std::nullopt;
  return CameraMixture{best->second, best->first_camera, best->second_camera, flat.rms_px,
                       std::sqrt(best->error_px2 / corners)};
}

}  // namespace ballservo
