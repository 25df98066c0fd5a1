#include "calibration/boards/calibration_checks.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/boards/board_calibration.hpp"
#include "calibration/boards/lens_choice.hpp"
#include "calibration/boards/mixed_cameras.hpp"

namespace ballservo {
namespace {

constexpr std::size_t least_views = 3;
constexpr double max_focal_sigma = 0.02;     // relative; above, the focal length is not determined
constexpr double same_angle_rad = 0.2;       // boards within this of each other stand at one angle
constexpr double same_distance = 1.2;        // ratio of the farthest to the nearest board, at one distance
constexpr double outlying_view = 3;          // times the median of the views' RMS
constexpr double least_noise_px = 0.1;       // that any corner finder has: below it an RMS is luck
constexpr double least_misfit_px = 0.15;     // RMS below which a lens is well explained, whatever the rest
constexpr double max_misfit_share = 0.7;     // of the RMS that a model with more coefficients may leave
constexpr std::size_t least_boards = 3;      // in a cell, to tell a common error from the boards' own
constexpr double max_structure_share = 0.6;  // of the RMS that may depend on the place in the picture

constexpr const char* what_to_photograph =
    "Photograph the whole board at least three times, better ten, tilted by 20 to 40 degrees to different "
    "sides, near and far, and near the picture's corners too.";

/// The largest angle (rad) between two boards' planes.
double angle_spread_rad(const std::vector<BoardPose>& poses) {
  double spread = 0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      spread = std::max(
          spread, std::acos(std::min(1.0, std::abs(board_normal(poses[i]).dot(board_normal(poses[j]))))));
  return spread;
}

/// The farthest board's distance over the nearest one's.
double distance_ratio(const std::vector<BoardPose>& poses) {
  double nearest = poses.front().tail<3>().norm(), farthest = nearest;
  for (const BoardPose& pose : poses) {
    nearest = std::min(nearest, pose.tail<3>().norm());
    farthest = std::max(farthest, pose.tail<3>().norm());
  }
  return farthest / nearest;
}

std::string why_no_focal_length(const BoardAdjustment& adjustment) {
  const bool one_angle = angle_spread_rad(adjustment.poses) < same_angle_rad;
  const bool one_distance = distance_ratio(adjustment.poses) < same_distance;
  if (one_angle && one_distance)
    return "all pictures show the board at nearly one angle and one distance, so that a longer lens farther "
           "away would give the same pictures. Tilt the board by 20 to 40 degrees, to different sides, and "
           "take pictures from near and from far";
  if (one_angle)
    return "all pictures show the board at nearly one angle, so that a longer lens farther away would give "
           "the same pictures. Tilt the board by 20 to 40 degrees, to different sides";
  if (one_distance)
    return "all pictures show the board at nearly one distance, and its tilt tells too little. Fill the "
           "picture with the board in some, and take others from twice as far";
  return "the boards are too few or too small in the picture";
}

[[noreturn]] void refuse_result(const std::string& what) {
  throw Refusal("The calibration came to a result that no camera has: " + what + ". " + what_to_photograph);
}

/// Distance (px) from the picture's farthest corner to the board corner nearest to it.
double farthest_corner_gap_px(const std::vector<BoardView>& believed, ImageSize size) {
  double gap = 0;
  for (const double x : {0.0, size.width_px - 1.0}) {
    for (const double y : {0.0, size.height_px - 1.0}) {
      double nearest = std::hypot(size.width_px, size.height_px);
      for (const BoardView& view : believed)
        for (const Eigen::Vector2d& corner : view.corners_px)
          nearest = std::min(nearest, (corner - Eigen::Vector2d(x, y)).norm());
      gap = std::max(gap, nearest);
    }
  }
  return gap;
}

// The picture's cells, over which corners are counted and residuals averaged.
constexpr int cells_across = 8, cells_down = 6;
constexpr std::size_t cell_count = cells_across * cells_down;

std::size_t cell_of(const Eigen::Vector2d& place_px, ImageSize size) {
  const int column =
      std::clamp(static_cast<int>(cells_across * place_px.x() / size.width_px), 0, cells_across - 1);
  const int row = std::clamp(static_cast<int>(cells_down * place_px.y() / size.height_px), 0, cells_down - 1);
  return static_cast<std::size_t>(row * cells_across + column);
}

using CellMeans =
    std::vector<std::vector<Eigen::Vector2d>>;  // of each cell, the mean of each board seen there

CellMeans cell_means(const std::vector<BoardView>& views, const BoardAdjustment& adjustment) {
  const ImageSize size = adjustment.parameters.size;
  CellMeans means(cell_count);
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::vector<Eigen::Vector2d> sums(means.size(), Eigen::Vector2d::Zero());
    std::vector<int> counts(means.size(), 0);
    for (std::size_t i = 0; i < views[v].size(); ++i) {
      if (adjustment.corners[v].set_aside[i]) continue;
      const std::size_t cell = cell_of(views[v].corners_px[i], size);
      sums[cell] += adjustment.corners[v].residuals_px[i];
      ++counts[cell];
    }
    for (std::size_t cell = 0; cell < means.size(); ++cell)
      if (counts[cell] > 0) means[cell].push_back(sums[cell] / counts[cell]);
  }
  return means;
}

}  // namespace

void require_enough_views(const std::vector<BoardView>& views) {
  if (views.size() < least_views)
    throw Refusal(fmt::format("Only {} picture{} of the board could be used. {}", views.size(),
                              views.size() == 1 ? "" : "s", what_to_photograph));
}

BoardCovariance require_focal_length(const std::vector<BoardView>& views, const BoardAdjustment& adjustment) {
  auto covariance = board_covariance(views, adjustment);
  double sigma = std::numeric_limits<double>::infinity();
  if (covariance) {
    const Eigen::MatrixXd& alone = covariance->of_independent_corners;
    const double noise_scale = std::max(least_noise_px, covariance->noise_px) / covariance->noise_px;
    sigma = noise_scale * std::max(std::sqrt(alone(0, 0)) / adjustment.parameters.fx_px,
                                   std::sqrt(alone(1, 1)) / adjustment.parameters.fy_px);
  }
  if (!(sigma < max_focal_sigma))
    throw Refusal(fmt::format(
        "The pictures do not determine the focal length{}: {}.",
        sigma < 1 ? fmt::format(" (it could be {:.0f} % off, and so could every distance)", 100 * sigma) : "",
        why_no_focal_length(adjustment)));
  return *covariance;
}

Camera require_sensible_camera(const std::vector<BoardView>& views, const BoardAdjustment& adjustment) {
  const CameraParameters& p = adjustment.parameters;
  if (!(p.fx_px > 0 && p.fy_px > 0 && p.fx_px / p.fy_px > 0.5 && p.fx_px / p.fy_px < 2))
    refuse_result(fmt::format("focal lengths {:.1f} and {:.1f} px", p.fx_px, p.fy_px));
  if (!(p.cx_px > -0.5 && p.cx_px < p.size.width_px - 0.5 && p.cy_px > -0.5 &&
        p.cy_px < p.size.height_px - 0.5))
    refuse_result(fmt::format("a principal point outside the picture ({:.1f}, {:.1f})", p.cx_px, p.cy_px));
  try {
    const Camera camera(p);
    for (const BoardView& view : views)
      for (const Eigen::Vector2d& corner : view.corners_px)
        if (!camera.unproject(corner))
          refuse_result(
              fmt::format("no ray reaches the board's point at ({:.1f}, {:.1f})", corner.x(), corner.y()));
    return camera;
  } catch (const InputError& error) {
    refuse_result(error.what());
  }
}

void require_one_camera(const std::vector<BoardView>& views, const BoardAdjustment& adjustment) {
  const auto mixture = find_mixed_cameras(views, adjustment);
  if (!mixture) return;
  std::array<std::vector<std::string>, 2> names;
  for (std::size_t v = 0; v < views.size(); ++v) names[mixture->second[v] ? 1 : 0].push_back(views[v].name);
  throw Refusal(fmt::format(
      "The pictures seem to come from two cameras (or from one whose zoom or focus changed): {} give a focal "
      "length of {:.1f} px and a principal point of ({:.1f}, {:.1f}), {} {:.1f} px and ({:.1f}, {:.1f}); "
      "together they fit with an RMS of {:.2f} px, apart with {:.2f}. Calibrate each camera from its own "
      "pictures, with autofocus off.",
      fmt::join(names[0], ", "), mixture->first_camera.fx_px, mixture->first_camera.cx_px,
      mixture->first_camera.cy_px, fmt::join(names[1], ", "), mixture->second_camera.fx_px,
      mixture->second_camera.cx_px, mixture->second_camera.cy_px, mixture->rms_together_px,
      mixture->rms_apart_px));
}

std::string lens_misfit(const std::vector<BoardView>& views, const std::vector<LensCandidate>& tried,
                        const BoardAdjustment& adjustment, std::optional<double> structure_px) {
  const CameraParameters& p = adjustment.parameters;
  if (adjustment.rms_px < least_misfit_px) return "";
  for (const LensCandidate& candidate : tried) {
    const BoardAdjustment& fit = candidate.adjustment;
    if (candidate.usable || fit.rms_px >= max_misfit_share * adjustment.rms_px) continue;
    const std::string_view other = lens_model_name(candidate.model());
    return fmt::format(
        "the lens model {} does not explain these pictures (RMS {:.2f} px); {} does ({:.2f} px), but is not "
        "determined over the whole picture: bring the board into the picture's corners, or give --model {} "
        "to take it as it is",
        lens_model_name(p.model), adjustment.rms_px, other, fit.rms_px, other);
  }
  std::vector<LensModel> others;
  for (const LensModel model : all_lens_models)
    if (std::none_of(tried.begin(), tried.end(),
                     [model](const LensCandidate& candidate) { return candidate.model() == model; }))
      others.push_back(model);
  std::sort(others.begin(), others.end(),
            [](LensModel m, LensModel n) { return coefficient_count(m) < coefficient_count(n); });
  std::optional<BoardAdjustment> better;
  for (const LensModel model : others) {
    auto fit = fit_lens(views, p.size, model);
    // More coefficients have to earn their place among the alternatives too.
    const double limit_px = better ? 0.9 * better->rms_px : max_misfit_share * adjustment.rms_px;
    if (fit && fit->rms_px < limit_px) better = std::move(fit);
  }
  const std::string_view name = lens_model_name(p.model);
  if (better)
    return fmt::format(
        "the lens model {} does not explain these pictures: its RMS is {:.2f} px, that of {} {:.2f} px; give "
        "--model {} (and a --format that holds it)",
        name, adjustment.rms_px, lens_model_name(better->parameters.model), better->rms_px,
        lens_model_name(better->parameters.model));
  if (structure_px && *structure_px > max_structure_share * adjustment.rms_px)
    return fmt::format(
        "no lens model explains these pictures: {:.2f} px of {}'s RMS of {:.2f} px depend on the place in "
        "the picture. Is the board flat, the shutter global, every picture sharp?",
        *structure_px, name, adjustment.rms_px);
  return "";
}

std::vector<std::string> calibration_warnings(const std::vector<BoardView>& views,
                                              const std::vector<BoardView>& believed,
                                              const BoardCalibration& calibration) {
  std::vector<std::string> warnings;
  std::vector<double> all_rms_px;
  for (const CornerResiduals& corners : calibration.corners) all_rms_px.push_back(corners.rms_px());
  const double typical_rms_px = upper_median(all_rms_px);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const CornerResiduals& corners = calibration.corners[v];
    const auto aside = std::count(corners.set_aside.begin(), corners.set_aside.end(), true);
    if (aside > 0)
      warnings.push_back(fmt::format("{}: {} of its {} corners do not fit this camera and were set aside",
                                     views[v].name, aside, views[v].size()));
    const double times = corners.rms_px() / std::max(typical_rms_px, least_noise_px);
    if (times > outlying_view)
      warnings.push_back(fmt::format("{} fits {:.1f} times worse than the median", views[v].name, times));
  }
  if (!std::isfinite(calibration.held_out_rms_px))
    warnings.push_back(
        "some of the boards alone give no camera, so there is no held-out error: take more pictures");
  if (!calibration.ball_sigma_mm)
    warnings.push_back(
        "the parameters are too uncertain to tell what that does to a ball: take more pictures, or a lens "
        "model with fewer coefficients");
  const CameraParameters& p = calibration.camera.parameters();
  if (!covers_picture(p))
    warnings.push_back(
        "a corner of the picture lies beyond where this lens model is one-to-one; there no 3-D is given");
  const double gap = farthest_corner_gap_px(believed, p.size),
               side = std::min(p.size.width_px, p.size.height_px);
  if (gap > side / 3)
    warnings.push_back(
        fmt::format("no board came nearer than {:.0f} px to one of the picture's corners{}", gap,
                    calibration.ball_sigma_mm && calibration.covered_ball_sigma_mm
                        ? fmt::format(": a ball at 1 m is uncertain by up to {:.1f} mm there, typically by "
                                      "{:.1f} mm where boards were",
                                      *calibration.ball_sigma_mm, *calibration.covered_ball_sigma_mm)
                        : ""));
  return warnings;
}

std::optional<double> covered_ball_sigma_mm(const std::vector<BoardView>& views,
                                            const BoardCalibration& calibration) {
  const auto map = ball_sigma_map(calibration.camera, calibration.covariance.parameters, 0.070, 1.0);
  if (!map) return std::nullopt;
  const double near_px = 0.05 * calibration.camera.size().width_px;
  const auto is_covered = [&](const Eigen::Vector2d& place) {
    for (const BoardView& view : views)
      for (const Eigen::Vector2d& corner : view.corners_px)
        if ((corner - place).norm() < near_px) return true;
    return false;
  };
  std::vector<double> covered;
  for (std::size_t i = 0; i < map->places_px.size(); ++i)
    if (map->sigma_mm[i] && is_covered(map->places_px[i])) covered.push_back(*map->sigma_mm[i]);
  if (covered.empty()) return std::nullopt;
  return upper_median(covered);
}

double picture_coverage(const std::vector<BoardView>& views, ImageSize size) {
  std::array<bool, cell_count> seen{};
  for (const BoardView& view : views)
    for (const Eigen::Vector2d& corner : view.corners_px) seen[cell_of(corner, size)] = true;
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) / static_cast<double>(cell_count);
}

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
