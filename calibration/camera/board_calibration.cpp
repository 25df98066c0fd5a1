#include "calibration/camera/board_calibration.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>

#include "calibration/camera/ball_uncertainty.hpp"
#include "calibration/camera/camera_covariance.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {
namespace {

constexpr std::size_t least_views = 3;
constexpr double good_start_rms_px = 1.0;
constexpr double badly_fitting_rms_px = 1.0;
constexpr double max_focal_sigma = 0.05;  // relative; above, the focal length is not determined
constexpr double outlying_view = 3;       // times the median of the views' RMS
constexpr double least_noise_px = 0.1;    // that any corner finder has: below it an RMS is luck

constexpr const char* what_to_photograph =
    "Photograph the whole board at least three times, better ten, tilted by 20 to 40 degrees to different "
    "sides, and near the picture's corners too.";

double view_rms(const BoardView& residuals) {
  double sum = 0;
  for (const Eigen::Vector2d& residual : residuals) sum += residual.squaredNorm();
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

/// The views, the board and the picture's size: what every step works on.
struct Task {
  std::vector<Eigen::Vector3d> points;
  std::vector<BoardView> views;
  ImageSize size;

  Task subset(const std::vector<std::size_t>& chosen) const {
    Task result{points, {}, size};
    for (const std::size_t i : chosen) result.views.push_back(views[i]);
    return result;
  }
};

/// Focal lengths to start from: what the homographies say (Zhang, PAMI 2000), then wide to long.
std::vector<double> focal_guesses_px(const Task& task) {
  std::vector<double> guesses;
  std::vector<std::vector<cv::Point3f>> object;
  std::vector<std::vector<cv::Point2f>> image;
  for (const BoardView& view : task.views) {
    object.emplace_back();
    image.emplace_back();
    for (std::size_t i = 0; i < view.size(); ++i) {
      object.back().emplace_back(static_cast<float>(task.points[i].x()),
                                 static_cast<float>(task.points[i].y()), 0.0f);
      image.back().emplace_back(static_cast<float>(view[i].x()), static_cast<float>(view[i].y()));
    }
  }
  const double side = std::max(task.size.width_px, task.size.height_px);
  try {
    const cv::Mat matrix =
        cv::initCameraMatrix2D(object, image, cv::Size(task.size.width_px, task.size.height_px), 1.0);
    const double focal = matrix.at<double>(0, 0);
    if (std::isfinite(focal) && focal > 0.05 * side && focal < 100 * side) guesses.push_back(focal);
  } catch (const cv::Exception&) {
    // Degenerate homographies: the other guesses remain.
  }
  for (const double share : {1.0, 0.6, 0.33, 2.0}) guesses.push_back(share * side);
  return guesses;
}

std::optional<BoardAdjustment> fit(const Task& task, LensModel model) {
  std::optional<BoardAdjustment> best;
  if (model == LensModel::brown8) {
    // From the polynomial lens, which is the rational one with three zeros, it is not far.
    best = fit(task, LensModel::brown);
    if (!best) return best;
    CameraParameters start = best->parameters;
    start.model = model;
    return adjust_boards(task.points, task.views, start, best->poses, false);
  }
  for (const double focal_px : focal_guesses_px(task)) {
    CameraParameters start;
    start.model = model;
    start.size = task.size;
    start.fx_px = start.fy_px = focal_px;
    start.cx_px = 0.5 * (task.size.width_px - 1);
    start.cy_px = 0.5 * (task.size.height_px - 1);
    const auto poses = board_poses(task.points, task.views, start);
    if (!poses) continue;
    auto result = adjust_boards(task.points, task.views, start, *poses, false);
    if (result && (!best || result->rms_px < best->rms_px)) best = std::move(result);
    if (best && best->rms_px < good_start_rms_px) break;
  }
  return best;
}

/// Mean squared error (px^2) of each view under a camera that was found without it; empty where that fails.
std::vector<double> held_out_errors_px2(const Task& task, const BoardAdjustment& all, int folds) {
  const std::size_t count = task.views.size();
  const std::size_t fold_count = std::min(count, static_cast<std::size_t>(folds));
  std::vector<double> errors(count, 0.0);
  for (std::size_t fold = 0; fold < fold_count; ++fold) {
    std::vector<std::size_t> kept, held_out;
    std::vector<BoardPose> kept_poses, held_out_poses;
    for (std::size_t i = 0; i < count; ++i) {
      (i % fold_count == fold ? held_out : kept).push_back(i);
      (i % fold_count == fold ? held_out_poses : kept_poses).push_back(all.poses[i]);
    }
    const Task others = task.subset(kept), tested = task.subset(held_out);
    const auto camera = adjust_boards(others.points, others.views, all.parameters, kept_poses, false);
    if (!camera) return {};
    const auto result = adjust_boards(tested.points, tested.views, camera->parameters, held_out_poses, true);
    if (!result) return {};
    for (std::size_t i = 0; i < held_out.size(); ++i)
      errors[held_out[i]] = std::pow(view_rms(result->residuals_px[i]), 2);
  }
  return errors;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

double standard_error(const std::vector<double>& values) {
  const double center = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - center) * (value - center);
  const auto count = static_cast<double>(values.size());
  return std::sqrt(sum / (count - 1) / count);
}

struct Candidate {
  BoardAdjustment adjustment;
  std::vector<double> held_out_px2;  // per view; empty: none
};

bool covers_picture(const Camera& camera) {
  const double right = camera.size().width_px - 1.0, bottom = camera.size().height_px - 1.0;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(0, 0), Eigen::Vector2d(right, 0),
                                        Eigen::Vector2d(0, bottom), Eigen::Vector2d(right, bottom)})
    if (!camera.unproject(corner)) return false;
  return true;
}

bool covers_picture(const CameraParameters& parameters) {
  try {
    return covers_picture(Camera(parameters));
  } catch (const InputError&) {
    return false;
  }
}

/// Whether a model may be chosen without having been asked for.
bool may_be_chosen(const Candidate& candidate) {
  return !candidate.held_out_px2.empty() && covers_picture(candidate.adjustment.parameters);
}

/// The simplest candidate within one standard error of the best (Breiman et al., 1984); the candidates come
/// simplest first.
std::size_t choose(const std::vector<Candidate>& candidates) {
  std::size_t best = candidates.size();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!may_be_chosen(candidates[i])) continue;
    if (best == candidates.size() || mean(candidates[i].held_out_px2) < mean(candidates[best].held_out_px2))
      best = i;
  }
  if (best == candidates.size()) return 0;
  // The boards are the same for all, so the standard error of the difference on each board counts: the
  // boards' own differences are common to both.
  for (std::size_t i = 0; i < best; ++i) {
    if (!may_be_chosen(candidates[i])) continue;
    std::vector<double> difference;
    for (std::size_t v = 0; v < candidates[i].held_out_px2.size(); ++v)
      difference.push_back(candidates[i].held_out_px2[v] - candidates[best].held_out_px2[v]);
    if (mean(difference) <= standard_error(difference)) return i;
  }
  return best;
}

/// Inverse of the information, or nothing where it has none.
std::optional<Eigen::MatrixXd> inverse_information(const Eigen::MatrixXd& information) {
  const Eigen::Index size = information.rows();
  Eigen::VectorXd scale(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!(information(i, i) > 0)) return std::nullopt;
    scale(i) = 1 / std::sqrt(information(i, i));
  }
  // Parameters differ in size by orders of magnitude: invert the correlations' matrix.
  Eigen::MatrixXd scaled = information;
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j) scaled(i, j) *= scale(i) * scale(j);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  // A direction that the boards leave open gets an enormous variance, and who needs it can tell.
  const double floor = 1e-15 * solver.eigenvalues()(size - 1);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index k = 0; k < size; ++k)
    inverse += solver.eigenvectors().col(k) * solver.eigenvectors().col(k).transpose() /
               std::max(floor, solver.eigenvalues()(k));
  for (Eigen::Index i = 0; i < size; ++i)
    for (Eigen::Index j = 0; j < size; ++j) inverse(i, j) *= scale(i) * scale(j);
  return inverse;
}

/// The parameters' covariance; Refusal where the boards do not determine the focal length.
Eigen::MatrixXd covariance_of(const Task& task, const BoardAdjustment& adjustment) {
  const auto inverse = inverse_information(camera_information(task.points, adjustment));
  double sum = 0;
  for (const BoardView& view : adjustment.residuals_px)
    for (const Eigen::Vector2d& residual : view) sum += residual.squaredNorm();
  const auto parameters = static_cast<double>(parameter_vector(adjustment.parameters).size());
  const auto views = static_cast<double>(task.views.size()), points = static_cast<double>(task.points.size());
  const double freedom = 2 * points * views - parameters - 6 * views;
  const double variance = sum / std::max(1.0, freedom);
  const double noise = std::max(least_noise_px, std::sqrt(variance));
  if (!inverse || !(noise * std::sqrt((*inverse)(0, 0)) < max_focal_sigma * adjustment.parameters.fx_px) ||
      !(noise * std::sqrt((*inverse)(1, 1)) < max_focal_sigma * adjustment.parameters.fy_px))
    throw Refusal(
        std::string(
            "The boards do not determine the focal length: they are too nearly parallel to each other "
            "(or to the picture), or too few or too small. ") +
        what_to_photograph);
  return variance * *inverse;
}

[[noreturn]] void refuse_result(const std::string& what) {
  throw Refusal("The calibration came to a result that makes no sense: " + what + ". " + what_to_photograph);
}

Camera sensible_camera(const Task& task, const BoardAdjustment& adjustment) {
  const CameraParameters& p = adjustment.parameters;
  if (!(p.cx_px > -0.5 && p.cx_px < p.size.width_px - 0.5 && p.cy_px > -0.5 &&
        p.cy_px < p.size.height_px - 0.5))
    refuse_result(fmt::format("a principal point outside the picture ({:.1f}, {:.1f})", p.cx_px, p.cy_px));
  if (!(p.fx_px > 0 && p.fy_px > 0 && p.fx_px / p.fy_px > 0.5 && p.fx_px / p.fy_px < 2))
    refuse_result(fmt::format("focal lengths {:.1f} and {:.1f} px", p.fx_px, p.fy_px));
  try {
    const Camera camera(p);
    for (const BoardView& view : task.views)
      for (const Eigen::Vector2d& corner : view)
        if (!camera.unproject(corner))
          refuse_result(
              fmt::format("no ray reaches the board's point at ({:.1f}, {:.1f})", corner.x(), corner.y()));
    return camera;
  } catch (const InputError& error) {
    refuse_result(error.what());
  }
}

std::vector<std::string> warnings_of(const BoardCalibration& result) {
  std::vector<std::string> warnings;
  if (result.rms_px > badly_fitting_rms_px)
    warnings.push_back(fmt::format("the model {} fits badly: RMS {:.2f} px (good corners give 0.1 to 0.5)",
                                   lens_model_name(result.camera.parameters().model), result.rms_px));
  std::vector<double> sorted = result.view_rms_px;
  std::sort(sorted.begin(), sorted.end());
  const double median = sorted[sorted.size() / 2];
  for (std::size_t v = 0; v < result.view_rms_px.size(); ++v)
    if (result.view_rms_px[v] > outlying_view * std::max(median, least_noise_px))
      warnings.push_back(fmt::format("board {} of those used fits {:.1f} times worse than the median", v + 1,
                                     result.view_rms_px[v] / median));
  if (!std::isfinite(result.held_out_rms_px))
    warnings.push_back(
        "some of the boards alone give no camera, so there is no held-out error: take more pictures");
  if (!covers_picture(result.camera))
    warnings.push_back(
        "a corner of the picture lies beyond where this lens model is one-to-one; there no 3-D is given");
  return warnings;
}

}  // namespace

void BoardCalibrationOptions::validate() const {
  FaultList faults;
  if (models.empty()) faults.add("lens models", "none", "at least one");
  if (folds < 2) faults.add("folds", fmt::format("{}", folds), "at least 2");
  faults.throw_if_any();
}

BoardCalibration calibrate_from_boards(const Board& board, ImageSize size,
                                       const std::vector<BoardView>& views,
                                       const BoardCalibrationOptions& options) {
  options.validate();
  const Task task{board.points(), views, size};
  for (const BoardView& view : views)
    if (view.size() != task.points.size())
      throw InputError("board view", fmt::format("{} points", view.size()),
                       fmt::format("{}, as the board has", task.points.size()));
  if (views.size() < least_views)
    throw Refusal(fmt::format("Only {} picture{} of the board could be used. {}", views.size(),
                              views.size() == 1 ? "" : "s", what_to_photograph));
  std::vector<LensModel> models = options.models;
  std::stable_sort(models.begin(), models.end(),
                   [](LensModel a, LensModel b) { return coefficient_count(a) < coefficient_count(b); });
  std::vector<Candidate> candidates;
  for (const LensModel model : models) {
    auto adjustment = fit(task, model);
    if (!adjustment) continue;
    auto held_out = held_out_errors_px2(task, *adjustment, options.folds);
    candidates.push_back({std::move(*adjustment), std::move(held_out)});
  }
  if (candidates.empty())
    throw Refusal(std::string("No camera fits these boards. Do rows and columns agree with the board? ") +
                  what_to_photograph);
  const Candidate& chosen = candidates[choose(candidates)];
  const BoardAdjustment& adjustment = chosen.adjustment;
  // Parallel boards first: what they give is absurd in any way it likes.
  Eigen::MatrixXd covariance = covariance_of(task, adjustment);
  BoardCalibration result{sensible_camera(task, adjustment),
                          std::move(covariance),
                          adjustment.rms_px,
                          std::sqrt(mean(chosen.held_out_px2)),
                          std::nullopt,
                          {},
                          adjustment.residuals_px,
                          adjustment.poses,
                          {},
                          {}};
  result.ball_sigma_mm = ball_sigma_mm(result.camera, result.covariance);
  for (const BoardView& residuals : adjustment.residuals_px)
    result.view_rms_px.push_back(view_rms(residuals));
  for (const Candidate& candidate : candidates)
    result.trials.push_back({candidate.adjustment.parameters.model, candidate.adjustment.rms_px,
                             std::sqrt(mean(candidate.held_out_px2)),
                             covers_picture(candidate.adjustment.parameters)});
  result.warnings = warnings_of(result);
  return result;
}

}  // namespace ballservo
