#include "calibration/boards/board_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/boards/corner_cost.hpp"
#include "calibration/camera/files/camera_covariance.hpp"

namespace ballservo {
namespace {

using PoseMatrix = Eigen::Matrix<double, 6, 6>;

/// The blocks of J'J that belong to one view.
struct ViewInformation {
  Eigen::MatrixXd camera, mixed;  // mixed: camera x pose
  PoseMatrix pose = PoseMatrix::Zero();
};

ViewInformation view_information(const BoardView& view, const BoardAdjustment& adjustment, std::size_t v) {
  const Eigen::VectorXd camera = parameter_vector(adjustment.parameters);
  const Eigen::Index size = camera.size();
  ViewInformation information{Eigen::MatrixXd::Zero(size, size), Eigen::MatrixXd::Zero(size, 6)};
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  RowMatrix jc(2, size), jp(2, 6);
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (adjustment.corners[v].set_aside[i]) continue;
    const double* blocks[] = {camera.data(), adjustment.poses[v].data()};
    double* jacobians[] = {jc.data(), jp.data()};
    double residual[2];
    if (!corner_cost(adjustment.parameters.model, view.points_m[i], view.corners_px[i])
             ->Evaluate(blocks, residual, jacobians))
      continue;
    information.camera += jc.transpose() * jc;
    information.mixed += jc.transpose() * jp;
    information.pose += jp.transpose() * jp;
  }
  return information;
}

/// Inverse of a normal matrix whose parameters differ in size by orders of magnitude: that of the
/// correlations' matrix, scaled back.
std::optional<Eigen::MatrixXd> scaled_inverse(const Eigen::MatrixXd& information) {
  const Eigen::Index size = information.rows();
  Eigen::VectorXd scale(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!(information(i, i) > 0)) return std::nullopt;
    scale(i) = 1 / std::sqrt(information(i, i));
  }
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  const double floor = 1e-15 * solver.eigenvalues()(size - 1);
  const Eigen::VectorXd inverse = solver.eigenvalues().cwiseMax(floor).cwiseInverse();
  return scale.asDiagonal() * solver.eigenvectors() * inverse.asDiagonal() *
         solver.eigenvectors().transpose() * scale.asDiagonal();
}

double noise_of(const BoardAdjustment& adjustment) {
  double sum = 0, freedom = 0;
  for (const CornerResiduals& corners : adjustment.corners) {
    for (std::size_t i = 0; i < corners.residuals_px.size(); ++i) {
      if (corners.set_aside[i]) continue;
      sum += corners.residuals_px[i].squaredNorm();
      freedom += 2;
    }
  }
  freedom -=
      static_cast<double>(parameter_vector(adjustment.parameters).size() + 6 * adjustment.poses.size());
  return std::sqrt(sum / std::max(1.0, freedom));
}

}  // namespace

std::optional<BoardCovariance> board_covariance(const std::vector<BoardView>& views,
                                                const BoardAdjustment& adjustment) {
  const Eigen::Index size = parameter_vector(adjustment.parameters).size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
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
    information += view.camera - view.mixed * follows;
    distance_by_camera -= share * follows.row(5);
    own_distance_variance += share * share * inverse(5, 5);
  }
  const auto inverse = scaled_inverse(information);
  if (!inverse || !inverse->allFinite()) return std::nullopt;
  const double covariance = (distance_by_camera * inverse->col(0)).value();
  const double distance_variance =
      own_distance_variance + (distance_by_camera * *inverse * distance_by_camera.transpose()).value();
  BoardCovariance result;
  result.noise_px = noise_of(adjustment);
  result.parameters = result.noise_px * result.noise_px * *inverse;
  result.focal_distance_correlation =
      std::clamp(covariance / std::sqrt((*inverse)(0, 0) * distance_variance), -1.0, 1.0);
  return result;
}

}  // namespace ballservo
