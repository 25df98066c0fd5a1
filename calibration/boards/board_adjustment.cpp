#include "calibration/boards/board_adjustment.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/boards/corner_cost.hpp"
#include "calibration/camera/files/camera_covariance.hpp"

namespace ballservo {
namespace {

/// Fills residuals and RMS of a finished adjustment; false where a point does not project.
bool evaluate(const std::vector<BoardView>& views, BoardAdjustment& adjustment) {
  const Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  double sum = 0;
  std::size_t count = 0;
  adjustment.corners.resize(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    CornerResiduals& corners = adjustment.corners[v];
    corners.set_aside.resize(views[v].size(), false);
    corners.residuals_px.clear();
    for (std::size_t i = 0; i < views[v].size(); ++i) {
      const double* blocks[] = {camera.data(), adjustment.poses[v].data()};
      Eigen::Vector2d residual(0, 0);
      if (!corner_cost(adjustment.parameters.model, views[v].points_m[i], views[v].corners_px[i])
               ->Evaluate(blocks, residual.data(), nullptr))
        return false;
      corners.residuals_px.push_back(residual);
      if (corners.set_aside[i]) continue;
      sum += residual.squaredNorm();
      ++count;
    }
  }
  adjustment.rms_px = std::sqrt(sum / static_cast<double>(count));
  return std::isfinite(adjustment.rms_px);
}

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  return options;
}

/// Moves an adjustment to its minimum over the corners that are not set aside; false where there is none.
/// `huber_px` 0: squares.
bool minimise(const std::vector<BoardView>& views, BoardAdjustment& adjustment, bool fixed_camera,
              double huber_px) {
  Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  ceres::HuberLoss huber(huber_px > 0 ? huber_px : 1);
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  problem.AddParameterBlock(camera.data(), static_cast<int>(camera.size()));
  if (fixed_camera) problem.SetParameterBlockConstant(camera.data());
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  double rows = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    problem.AddParameterBlock(adjustment.poses[v].data(), 6);
    for (std::size_t i = 0; i < views[v].size(); ++i) {
      if (adjustment.corners[v].set_aside[i]) continue;
      problem.AddResidualBlock(
          corner_cost(adjustment.parameters.model, views[v].points_m[i], views[v].corners_px[i]).release(),
          huber_px > 0 ? &huber : nullptr, camera.data(), adjustment.poses[v].data());
      rows += 2;
    }
    ordering->AddElementToGroup(adjustment.poses[v].data(), 0);
  }
  if (!fixed_camera) ordering->AddElementToGroup(camera.data(), 1);
  ceres::Solver::Options options = solver_options();
  // The normal equations of a rational lens, whose numerator and denominator can trade places, often fail to
  // factorise: there the QR decomposition, as long as it costs less than a second a step.
  const double columns = static_cast<double>(camera.size()) + 6.0 * static_cast<double>(views.size());
  const bool by_qr =
      fixed_camera || (adjustment.parameters.model == LensModel::brown8 && rows * columns * columns < 1e9);
  options.linear_solver_type = by_qr ? ceres::DENSE_QR : ceres::DENSE_SCHUR;
  options.linear_solver_ordering = by_qr ? nullptr : ordering;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  adjustment.converged = summary.termination_type == ceres::CONVERGENCE;
  adjustment.parameters = with_parameter_vector(adjustment.parameters, camera);
  return summary.IsSolutionUsable() && camera.allFinite() && evaluate(views, adjustment);
}

/// Standard deviation of a coordinate from the median of the residuals' sizes, which wrong corners do not
/// move.
double robust_sigma_px(const CornerResiduals& corners) {
  std::vector<double> sizes;
  for (const Eigen::Vector2d& residual : corners.residuals_px)
    for (const double coordinate : {residual.x(), residual.y()}) sizes.push_back(std::abs(coordinate));
  return sigma_of_median * upper_median(sizes);
}

/// The median of the views' standard deviations.
double typical_sigma_px(const BoardAdjustment& adjustment) {
  std::vector<double> sigmas;
  for (const CornerResiduals& corners : adjustment.corners) sigmas.push_back(robust_sigma_px(corners));
  return upper_median(sigmas);
}

/// Sets aside the corners that are plainly wrong beside the others of their own view, which may be blurred as
/// a whole, and takes back those that are not; whether anything changed.
bool set_wrong_corners_aside(BoardAdjustment& adjustment) {
  // Where boards fit (nearly) exactly, rounding is no reason to call a corner wrong.
  constexpr double wrong_sigmas = 6, least_wrong_px = 0.05;
  const double typical_px = typical_sigma_px(adjustment);
  bool changed = false;
  for (CornerResiduals& corners : adjustment.corners) {
    const double sigma_px = std::max(typical_px, robust_sigma_px(corners));
    const double limit_px = std::max(least_wrong_px, wrong_sigmas * sigma_px);
    for (std::size_t i = 0; i < corners.residuals_px.size(); ++i) {
      const bool wrong = corners.residuals_px[i].norm() > limit_px;
      changed = changed || wrong != corners.set_aside[i];
      corners.set_aside[i] = wrong;
    }
  }
  return changed;
}

std::optional<BoardAdjustment> started(const std::vector<BoardView>& views, const CameraParameters& start,
                                       const std::vector<BoardPose>& start_poses) {
  BoardAdjustment result{start, start_poses, {}, 0, false};
  // From a start behind the lens there is no way forward.
  if (views.empty() || !evaluate(views, result)) return std::nullopt;
  return result;
}

}  // namespace

double CornerResiduals::rms_px() const {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < residuals_px.size(); ++i) {
    if (set_aside[i]) continue;
    sum += residuals_px[i].squaredNorm();
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

std::optional<BoardAdjustment> adjust_boards(const std::vector<BoardView>& views,
                                             const CameraParameters& start,
                                             const std::vector<BoardPose>& start_poses, CornerLoss loss) {
  auto result = started(views, start, start_poses);
  if (!result || !minimise(views, *result, false, 0)) return std::nullopt;
  if (loss == CornerLoss::squares) return result;
  const BoardAdjustment squares = *result;
  BoardAdjustment marked = squares;
  if (!set_wrong_corners_aside(marked)) return squares;
  constexpr int max_rounds = 4;
  constexpr double huber_sigmas = 1.345;  // 95 % efficient where all residuals are normal (Huber, 1964)
  if (!minimise(views, *result, false, huber_sigmas * typical_sigma_px(*result)) ||
      !set_wrong_corners_aside(*result))
    return squares;
  for (int round = 0; round < max_rounds; ++round) {
    if (!minimise(views, *result, false, 0)) return std::nullopt;
    if (round + 1 == max_rounds || !set_wrong_corners_aside(*result)) break;
  }
  return result;
}

std::optional<BoardAdjustment> adjust_poses(const std::vector<BoardView>& views,
                                            const CameraParameters& camera,
                                            const std::vector<BoardPose>& start_poses) {
  auto result = started(views, camera, start_poses);
  if (!result) return std::nullopt;
  result->converged = true;
  // Under a camera that stays, no pose has to do with another.
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::vector<BoardView> view{views[v]};
    auto one = started(view, camera, {start_poses[v]});
    if (!one || !minimise(view, *one, true, 0)) return std::nullopt;
    result->poses[v] = one->poses.front();
    result->converged = result->converged && one->converged;
  }
  if (!evaluate(views, *result)) return std::nullopt;
  return result;
}

std::vector<BoardView> believed_corners(const std::vector<BoardView>& views,
                                        const BoardAdjustment& adjustment) {
  std::vector<BoardView> result(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    result[v].name = views[v].name;
    for (std::size_t i = 0; i < views[v].size(); ++i) {
      if (adjustment.corners[v].set_aside[i]) continue;
      result[v].points_m.push_back(views[v].points_m[i]);
      result[v].corners_px.push_back(views[v].corners_px[i]);
    }
  }
  return result;
}

std::optional<std::vector<BoardPose>> board_poses(const std::vector<BoardView>& views,
                                                  const CameraParameters& parameters) {
  std::vector<BoardPose> poses;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  try {
    const Camera camera(parameters);
    for (const BoardView& view : views) {
      std::vector<cv::Point3d> object;
      std::vector<cv::Point2d> image;
      for (std::size_t i = 0; i < view.size(); ++i) {
        const auto ray = camera.unproject(view.corners_px[i]);
        // Rays across the axis or behind have no place on the plane Z = 1; the others settle the pose.
        if (!ray || ray->z() < 0.05) continue;
        object.emplace_back(view.points_m[i].x(), view.points_m[i].y(), view.points_m[i].z());
        image.emplace_back(ray->x() / ray->z(), ray->y() / ray->z());
      }
      cv::Mat rotation, translation;
      if (object.size() < 6 || !cv::solvePnP(object, image, identity, cv::noArray(), rotation, translation))
        return std::nullopt;
      BoardPose& pose = poses.emplace_back();
      for (int i = 0; i < 3; ++i) {
        pose(i) = rotation.at<double>(i);
        pose(3 + i) = translation.at<double>(i);
      }
      if (!pose.allFinite()) return std::nullopt;
    }
  } catch (const InputError&) {
    return std::nullopt;
  } catch (const cv::Exception&) {
    return std::nullopt;
  }
  return poses;
}

}  // namespace ballservo
