#include "calibration/camera/board_adjustment.hpp"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "calibration/camera/camera_covariance.hpp"
#include "calibration/camera/lens/lens_list.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {
namespace {

/// Projected minus found position of one corner (px).
template <class Lens>
struct CornerResidual {
  Eigen::Vector3d point;
  Eigen::Vector2d corner_px;

  template <class T>
  bool operator()(const T* camera, const T* pose, T* residual) const {
    const T on_board[3] = {T(point.x()), T(point.y()), T(point.z())};
    T p[3];
    ceres::AngleAxisRotatePoint(pose, on_board, p);
    const Ray3<T> ray{p[0] + pose[3], p[1] + pose[4], p[2] + pose[5]};
    if (Lens::perspective && !(scalar_part(ray.z) > 0)) return false;
    const Position2<T> m = Lens::distort(camera + 4, ray);
    residual[0] = camera[2] + camera[0] * m.x - corner_px.x();
    residual[1] = camera[3] + camera[1] * m.y - corner_px.y();
    return std::isfinite(scalar_part(residual[0])) && std::isfinite(scalar_part(residual[1]));
  }
};

std::unique_ptr<ceres::CostFunction> corner_cost(LensModel model, const Eigen::Vector3d& point,
                                                 const Eigen::Vector2d& corner_px) {
  return with_lens(model, [&](auto lens) -> std::unique_ptr<ceres::CostFunction> {
    using Lens = decltype(lens);
    using Residual = CornerResidual<Lens>;
    return std::make_unique<ceres::AutoDiffCostFunction<Residual, 2, 4 + lens_coefficient_count<Lens>, 6>>(
        new Residual{point, corner_px});
  });
}

/// Fills residuals and RMS of a finished adjustment; false where a point does not project.
bool evaluate(const std::vector<Eigen::Vector3d>& board_points, const std::vector<BoardView>& views,
              BoardAdjustment& adjustment) {
  const Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  double sum = 0;
  std::size_t count = 0;
  adjustment.residuals_px.clear();
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto& residuals = adjustment.residuals_px.emplace_back();
    for (std::size_t i = 0; i < board_points.size(); ++i) {
      const double* blocks[] = {camera.data(), adjustment.poses[v].data()};
      Eigen::Vector2d residual(0, 0);
      if (!corner_cost(adjustment.parameters.model, board_points[i], views[v][i])
               ->Evaluate(blocks, residual.data(), nullptr))
        return false;
      sum += residual.squaredNorm();
      ++count;
      residuals.push_back(residual);
    }
  }
  adjustment.rms_px = std::sqrt(sum / static_cast<double>(count));
  return std::isfinite(adjustment.rms_px);
}

}  // namespace

std::optional<BoardAdjustment> adjust_boards(const std::vector<Eigen::Vector3d>& board_points,
                                             const std::vector<BoardView>& views,
                                             const CameraParameters& start,
                                             const std::vector<BoardPose>& start_poses, bool fixed_camera) {
  Eigen::VectorXd camera = parameter_vector(start);
  BoardAdjustment result{start, start_poses, {}, 0, false};
  // From a start behind the lens there is no way forward.
  if (!evaluate(board_points, views, result)) return std::nullopt;
  ceres::Problem problem;
  problem.AddParameterBlock(camera.data(), static_cast<int>(camera.size()));
  if (fixed_camera) problem.SetParameterBlockConstant(camera.data());
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (std::size_t i = 0; i < board_points.size(); ++i)
      problem.AddResidualBlock(corner_cost(start.model, board_points[i], views[v][i]).release(), nullptr,
                               camera.data(), result.poses[v].data());
    ordering->AddElementToGroup(result.poses[v].data(), 0);
  }
  if (!fixed_camera) ordering->AddElementToGroup(camera.data(), 1);
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  // The normal equations of a rational lens, whose numerator and denominator can trade places, often fail to
  // factorise: there the QR decomposition, as long as it costs less than a second a step.
  const double rows = 2.0 * static_cast<double>(board_points.size() * views.size());
  const double columns = static_cast<double>(camera.size()) + 6.0 * static_cast<double>(views.size());
  const bool by_qr = fixed_camera || (start.model == LensModel::brown8 && rows * columns * columns < 1e9);
  options.linear_solver_type = by_qr ? ceres::DENSE_QR : ceres::DENSE_SCHUR;
  options.linear_solver_ordering = by_qr ? nullptr : ordering;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.gradient_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.parameters = with_parameter_vector(start, camera);
  if (!summary.IsSolutionUsable() || !camera.allFinite() || !evaluate(board_points, views, result))
    return std::nullopt;
  return result;
}

std::optional<std::vector<BoardPose>> board_poses(const std::vector<Eigen::Vector3d>& board_points,
                                                  const std::vector<BoardView>& views,
                                                  const CameraParameters& parameters) {
  std::vector<BoardPose> poses;
  const cv::Mat identity = cv::Mat::eye(3, 3, CV_64F);
  try {
    const Camera camera(parameters);
    for (const BoardView& view : views) {
      std::vector<cv::Point3d> object;
      std::vector<cv::Point2d> image;
      for (std::size_t i = 0; i < view.size(); ++i) {
        const auto ray = camera.unproject(view[i]);
        // Rays across the axis or behind have no place on the plane Z = 1; the others settle the pose.
        if (!ray || ray->z() < 0.05) continue;
        object.emplace_back(board_points[i].x(), board_points[i].y(), board_points[i].z());
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

Eigen::MatrixXd camera_information(const std::vector<Eigen::Vector3d>& board_points,
                                   const BoardAdjustment& adjustment) {
  const Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  const Eigen::Index size = camera.size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (const BoardPose& pose : adjustment.poses) {
    Eigen::MatrixXd by_camera = Eigen::MatrixXd::Zero(size, size), mixed = Eigen::MatrixXd::Zero(size, 6);
    Eigen::Matrix<double, 6, 6> by_pose = Eigen::Matrix<double, 6, 6>::Zero();
    for (const Eigen::Vector3d& point : board_points) {
      RowMatrix jc = RowMatrix::Zero(2, size), jp = RowMatrix::Zero(2, 6);
      const double* blocks[] = {camera.data(), pose.data()};
      double* jacobians[] = {jc.data(), jp.data()};
      double residual[2];
      if (!corner_cost(adjustment.parameters.model, point, Eigen::Vector2d::Zero())
               ->Evaluate(blocks, residual, jacobians))
        continue;
      by_camera += jc.transpose() * jc;
      mixed += jc.transpose() * jp;
      by_pose += jp.transpose() * jp;
    }
    information += by_camera - mixed * by_pose.ldlt().solve(mixed.transpose());
  }
  return information;
}

}  // namespace ballservo
