#include "calibration/boards/lens_choice.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/calib3d.hpp>

#include "calibration/ball/ball_uncertainty.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {
namespace {

constexpr double good_start_rms_px = 1.0;

/// Focal lengths to start from: what the homographies say (Zhang, PAMI 2000), then wide to long.
std::vector<double> focal_guesses_px(const std::vector<BoardView>& views, ImageSize size) {
  std::vector<double> guesses;
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (const BoardView& view : views) {
    object.emplace_back();
    image.emplace_back();
    for (std::size_t i = 0; i < view.size(); ++i) {
      object.back().emplace_back(static_cast<float>(view.points_m[i].x()),
                                 static_cast<float>(view.points_m[i].y()), 0.0f);
      image.back().emplace_back(static_cast<float>(view.corners_px[i].x()),
                                static_cast<float>(view.corners_px[i].y()));
    }
  }
  const double side = std::max(size.width_px, size.height_px);
  try {
    const cv::Mat matrix =
        cv::initCameraMatrix2D(object, image, cv::Size(size.width_px, size.height_px), 1.0);
    const double focal = matrix.at<double>(0, 0);
    if (std::isfinite(focal) && focal > 0.05 * side && focal < 100 * side) guesses.push_back(focal);
  } catch (const cv::Exception&) {
    // Degenerate homographies: the other guesses remain.
  }
  for (const double share : {1.0, 0.6, 0.33, 2.0}) guesses.push_back(share * side);
  return guesses;
}

std::vector<double> fold_errors_px2(const std::vector<BoardView>& views, const BoardAdjustment& all) {
  const std::size_t fold_count = std::min<std::size_t>(views.size(), 4);
  std::vector<double> errors(views.size(), 0.0);
  for (std::size_t fold = 0; fold < fold_count; ++fold) {
    const auto is_tested = [&](std::size_t i) { return i % fold_count == fold; };
    const BoardGroup kept = board_group(views, all, std::not_fn(is_tested)),
                     tested = board_group(views, all, is_tested);
    const auto camera = adjust_boards(kept.views, all.parameters, kept.poses);
    if (!camera) return {};
    const auto result = adjust_poses(tested.views, camera->parameters, tested.poses);
    if (!result) return {};
    for (std::size_t i = fold, k = 0; i < views.size(); i += fold_count, ++k)
      errors[i] = std::pow(result->corners[k].rms_px(), 2);
  }
  return errors;
}

bool is_usable(const std::vector<BoardView>& views, const BoardAdjustment& adjustment) {
  if (!covers_picture(adjustment.parameters)) return false;
  const auto covariance = board_covariance(views, adjustment);
  constexpr int places_a_side = 5;  // are enough to see whether anything can be told
  return covariance && ball_sigma_map(Camera(adjustment.parameters), covariance->of_independent_corners,
                                      0.070, 1.0, places_a_side, places_a_side);
}

}  // namespace

double LensCandidate::held_out_rms_px() const { return std::sqrt(mean(held_out_px2)); }

bool covers_picture(const CameraParameters& parameters) {
  try {
    const Camera camera(parameters);
    const double right = camera.size().width_px - 1.0, bottom = camera.size().height_px - 1.0;
    for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0),
                                          Eigen::Vector2d(0, bottom), Eigen::Vector2d(right, bottom)})
      if (!camera.unproject(corner)) return false;
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::optional<BoardAdjustment> fit_lens(const std::vector<BoardView>& views, ImageSize size,
                                        LensModel model) {
  if (model == LensModel::brown8) {
    // From the polynomial lens, which is the rational one with three zeros, it is not far.
    const auto brown = fit_lens(views, size, LensModel::brown);
    if (!brown) return std::nullopt;
    CameraParameters start = brown->parameters;
    start.model = model;
    return adjust_boards(views, start, brown->poses, CornerLoss::robust);
  }
  std::optional<BoardAdjustment> best;
  for (const double focal_px : focal_guesses_px(views, size)) {
    CameraParameters start;
    start.model = model;
    start.size = size;
    start.fx_px = start.fy_px = focal_px;
    start.cx_px = 0.5 * (size.width_px - 1);
    start.cy_px = 0.5 * (size.height_px - 1);
    const auto poses = board_poses(views, start);
    if (!poses) continue;
    auto result = adjust_boards(views, start, *poses, CornerLoss::robust);
    if (result && (!best || result->rms_px < best->rms_px)) best = std::move(result);
    if (best && best->rms_px < good_start_rms_px) break;
  }
  return best;
}

std::vector<LensCandidate> lens_candidates(const std::vector<BoardView>& views, ImageSize size,
                                           std::vector<LensModel> models) {
  std::stable_sort(models.begin(), models.end(),
                   [](LensModel a, LensModel b) { return coefficient_count(a) < coefficient_count(b); });
  std::vector<LensCandidate> candidates;
  for (const LensModel model : models)
    if (auto adjustment = fit_lens(views, size, model))
      candidates.push_back({std::move(*adjustment), {}, false});
  if (candidates.empty()) return candidates;
  // All are tested on the same corners, those that the best fitting one believes: a poor model holds for
  // wrong what it cannot explain.
  const auto best = std::min_element(candidates.begin(), candidates.end(),
                                     [](const LensCandidate& a, const LensCandidate& b) {
                                       return a.adjustment.rms_px < b.adjustment.rms_px;
                                     });
  const std::vector<BoardView> believed = believed_corners(views, best->adjustment);
  for (LensCandidate& candidate : candidates) {
    candidate.held_out_px2 = fold_errors_px2(believed, candidate.adjustment);
    candidate.usable = is_usable(views, candidate.adjustment);
  }
  return candidates;
}

std::size_t choose_lens(const std::vector<LensCandidate>& candidates) {
  std::vector<std::size_t> allowed;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].usable && !candidates[i].held_out_px2.empty()) allowed.push_back(i);
  if (allowed.empty()) return 0;
  const auto errors_px2 = [&](std::size_t i) -> const std::vector<double>& {
    return candidates[i].held_out_px2;
  };
  const std::size_t best = *std::min_element(
      allowed.begin(), allowed.end(),
      [&](std::size_t a, std::size_t b) { return mean(errors_px2(a)) < mean(errors_px2(b)); });
  return *std::find_if(allowed.begin(), allowed.end(), [&](std::size_t i) {
    std::vector<double> difference;
    for (std::size_t v = 0; v < errors_px2(i).size(); ++v)
      difference.push_back(errors_px2(i)[v] - errors_px2(best)[v]);
    const double standard_error = standard_deviation(difference) / std::sqrt(difference.size());
    return i == best || mean(difference) <= standard_error;
  });
}

}  // namespace ballservo
