#include "calibration/boards/board_adjustment.hpp"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "calibration/base/fault.hpp"
#include "calibration/base/statistics.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/lens/lens_models.hpp"

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

/// The residual of one corner by the camera's parameters (in parameter_names' order) and the board's pose,
/// differentiated automatically.
std::unique_ptr<ceres::CostFunction> corner_cost(LensModel model, const Eigen::Vector3d& point,
                                                 const Eigen::Vector2d& corner_px) {
  return with_lens(model, [&](auto lens) -> std::unique_ptr<ceres::CostFunction> {
    using Lens = decltype(lens);
    using Residual = CornerResidual<Lens>;
    return std::make_unique<ceres::AutoDiffCostFunction<Residual, 2, 4 + lens_coefficient_count<Lens>, 6>>(
        new Residual{point, corner_px});
  });
}

/// The sum of the squared residuals (px^2) of the corners that are not set aside.
struct SquaredDistances {
  double sum_px2 = 0, count = 0;

  void add(const CornerResiduals& corners) {
    for (std::size_t i = 0; i < corners.residuals_px.size(); ++i) {
      if (corners.set_aside[i]) continue;
      sum_px2 += corners.residuals_px[i].squaredNorm();
      ++count;
    }
  }
  double rms_px() const { return std::sqrt(sum_px2 / count); }
};

/// Fills residuals and RMS of a finished adjustment; false where a point does not project.
bool evaluate(const std::vector<BoardView>& views, BoardAdjustment& adjustment) {
  const Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  SquaredDistances all;
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
    }
    all.add(corners);
  }
  adjustment.rms_px = all.rms_px();
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

using PoseMatrix = Eigen::Matrix<double, 6, 6>;

/// The blocks of J'J and of J'r that belong to one view.
struct ViewInformation {
  Eigen::MatrixXd camera, mixed;  // mixed: camera x pose
  PoseMatrix pose = PoseMatrix::Zero();
  Eigen::VectorXd camera_gradient;
};

ViewInformation view_information(const BoardView& view, const BoardAdjustment& adjustment, std::size_t v) {
  const Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  const Eigen::Index size = camera.size();
  ViewInformation information{Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, 6),
                              PoseMatrix::Zero(), Eigen::VectorXd::Zero(size)};
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMatrix jc(2, size), jp(2, 6);
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (adjustment.corners[v].set_aside[i]) continue;
    const double* blocks[] = {camera.data(), adjustment.poses[v].data()};
    double* jacobians[] = {jc.data(), jp.data()};
    Eigen::Vector2d residual;
    if (!corner_cost(adjustment.parameters.model, view.points_m[i], view.corners_px[i])
             ->Evaluate(blocks, residual.data(), jacobians))
      continue;
    information.camera_gradient += jc.transpose() * residual;
    information.camera += jc.transpose() * jc;
    information.mixed += jc.transpose() * jp;
    information.pose += jp.transpose() * jp;
  }
  return information;
}

/// R with R R' = the inverse of a normal matrix whose parameters differ in size by orders of magnitude: that
/// of the correlations' matrix, scaled back; and the inverse of R.
struct InverseRoot {
  Eigen::MatrixXd root, back;

  Eigen::MatrixXd inverse() const { return root * root.transpose(); }
};

std::optional<InverseRoot> inverse_root(const Eigen::MatrixXd& information) {
  const Eigen::Index size = information.rows();
  Eigen::VectorXd scale(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!(information(i, i) > 0)) return std::nullopt;
    scale(i) = 1 / std::sqrt(information(i, i));
  }
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const double floor = 1e-15 * solver.eigenvalues()(size - 1);
  const Eigen::VectorXd roots = solver.eigenvalues().cwiseMax(floor).cwiseSqrt();
  InverseRoot result{
      scale.asDiagonal() * solver.eigenvectors() * roots.cwiseInverse().asDiagonal(),
      roots.asDiagonal() * solver.eigenvectors().transpose() * scale.cwiseInverse().asDiagonal()};
  if (!result.root.allFinite() || !result.back.allFinite()) return std::nullopt;
  return result;
}

/// What one view says of the camera, its pose eliminated.
struct ReducedView {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;  // the pose's own is zero at the minimum
};

/// See board_covariance; `root` belongs to the sum of the views' information.
std::optional<Eigen::MatrixXd> clustered_covariance(const std::vector<ReducedView>& views,
                                                    const Eigen::MatrixXd& information,
                                                    const InverseRoot& root, double noise_px) {
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(information.rows(), information.cols());
  for (const ReducedView& view : views) {
    const auto without = inverse_root(information - view.information);
    if (!without) return std::nullopt;
    const Eigen::VectorXd step = root.back * (without->root * (without->root.transpose() * view.gradient));
    spread += step * step.transpose();
  }
  const auto count = static_cast<double>(views.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver((count - 1) / count * spread);
  const Eigen::MatrixXd axes = root.root * solver.eigenvectors();
  return axes * solver.eigenvalues().cwiseMax(noise_px * noise_px).asDiagonal() * axes.transpose();
}

double noise_of(const BoardAdjustment& adjustment) {
  SquaredDistances squares;
  for (const CornerResiduals& corners : adjustment.corners) squares.add(corners);
  const auto unknowns =
      static_cast<double>(parameter_vector(adjustment.parameters).size() + 6 * adjustment.poses.size());
  return std::sqrt(squares.sum_px2 / std::max(1.0, 2 * squares.count - unknowns));
}

}  // namespace

Eigen::Vector3d board_normal(const BoardPose& pose) {
  const Eigen::Vector3d turn = pose.head<3>();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()) * Eigen::Vector3d::UnitZ();
}

double CornerResiduals::rms_px() const {
  SquaredDistances squares;
  squares.add(*this);
  return squares.rms_px();
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

Eigen::Matrix<double, 6, 6> pose_information(const BoardView& view, const BoardAdjustment& adjustment,
                                             std::size_t index) {
  return view_information(view, adjustment, index).pose;
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

std::optional<BoardCovariance> board_covariance(const std::vector<BoardView>& views,
                                                const BoardAdjustment& adjustment) {
  const Eigen::Index size = parameter_vector(adjustment.parameters).size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  std::vector<ReducedView> reduced;
  // The mean distance is the mean of the poses' last entries; its covariance with the camera comes from how
  // each pose follows the camera: d pose / d camera = -(J_p'J_p)^-1 J_p'J_c.
  Eigen::RowVectorXd distance_by_camera = Eigen::RowVectorXd::Zero(size);
  double own_distance_variance = 0;
  const double share = 1 / static_cast<double>(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) {
    const ViewInformation view = view_information(views[v], adjustment, v);
    const Eigen::LDLT<PoseMatrix> pose(view.pose);
    const Eigen::MatrixXd follows = pose.solve(view.mixed.transpose());
    const PoseMatrix inverse = pose.solve(PoseMatrix::Identity());
    if (!follows.allFinite() || !inverse.allFinite()) continue;
    reduced.push_back({view.camera - view.mixed * follows, view.camera_gradient});
    information += reduced.back().information;
    distance_by_camera -= share * follows.row(5);
    own_distance_variance += share * share * inverse(5, 5);
  }
  const auto root = inverse_root(information);
  if (!root) return std::nullopt;
  const Eigen::MatrixXd inverse = root->inverse();
  const double covariance = (distance_by_camera * inverse.col(0)).value();
  const double distance_variance =
      own_distance_variance + (distance_by_camera * inverse * distance_by_camera.transpose()).value();
  BoardCovariance result;
  result.noise_px = noise_of(adjustment);
  const auto clustered = clustered_covariance(reduced, information, *root, result.noise_px);
  if (!clustered || !clustered->allFinite()) return std::nullopt;
  result.parameters = *clustered;
  result.of_independent_corners = result.noise_px * result.noise_px * inverse;
  result.focal_distance_correlation =
      std::clamp(covariance / std::sqrt(inverse(0, 0) * distance_variance), -1.0, 1.0);
  return result;
}

}  // namespace ballservo
