#include "calibration/ball/ball_uncertainty.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_covariance.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation_of(covariance));
  Eigen::MatrixXd root = solver.eigenvectors();
  for (Eigen::Index j = 0; j < root.cols(); ++j) {
    root.col(j) *= std::sqrt(std::max(0.0, solver.eigenvalues()(j)));
    root.col(j).array() *= sigma.array();
  }
  return root;
}

CameraUncertainty::CameraUncertainty(const Camera& camera, const Eigen::MatrixXd& covariance)
    : camera_(camera) {
  if (covariance.size() == 0) return;
  const CameraParameters& known = camera.parameters();
  const Eigen::VectorXd parameters = parameter_vector(known);
  const Eigen::MatrixXd root = covariance_root(covariance);
  for (Eigen::Index axis = 0; valid_ && axis < root.cols(); ++axis) {
    if (!(root.col(axis).norm() > 0)) continue;
    const Eigen::VectorXd change = step_sigmas * root.col(axis);
    try {
      changed_.emplace_back(Camera(with_parameter_vector(known, parameters + change)),
                            Camera(with_parameter_vector(known, parameters - change)));
    } catch (const InputError&) {
      valid_ = false;
    }
  }
}

std::optional<Eigen::Matrix3d> CameraUncertainty::ball_covariance(const Eigen::Vector3d& p_C,
                                                                  double radius_m) const {
  const auto outline = project_outline(camera_, p_C, radius_m, outline_points);
  if (outline.empty()) return std::nullopt;
  const auto along_axes = derivatives<Eigen::Vector3d>(
      [&](const Camera& changed) { return sphere_from_outline(changed, outline, radius_m); });
  if (!along_axes) return std::nullopt;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& derivative : *along_axes) sum += derivative * derivative.transpose();
  if (!sum.allFinite()) return std::nullopt;
  return sum;
}

std::optional<double> CameraUncertainty::ball_sigma_mm(const Eigen::Vector3d& p_C, double radius_m) const {
  const auto covariance_m2 = ball_covariance(p_C, radius_m);
  return covariance_m2 ? std::optional(1e3 * std::sqrt(covariance_m2->trace())) : std::nullopt;
}

std::optional<double> BallSigmaMap::worst_mm() const {
  std::optional<double> worst;
  for (const auto& sigma : sigma_mm)
    if (sigma && (!worst || *sigma > *worst)) worst = sigma;
  return worst;
}

std::optional<BallSigmaMap> ball_sigma_map(const Camera& camera, const Eigen::MatrixXd& covariance,
                                           double diameter_m, double range_m, int columns, int rows) {
  const double radius_m = 0.5 * diameter_m;
  const ImageSize size = camera.size();
  const CameraUncertainty uncertainty(camera, covariance);
  BallSigmaMap map{columns, rows, {}, {}};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d place((size.width_px - 1.0) * column / (columns - 1),
                                  (size.height_px - 1.0) * row / (rows - 1));
      map.places_px.push_back(place);
      map.sigma_mm.emplace_back();
      const auto ray = camera.unproject(place);
      if (!ray || !is_inside_picture(project_outline(camera, *ray * range_m, radius_m, outline_points), size))
        continue;
      map.sigma_mm.back() = uncertainty.ball_sigma_mm(*ray * range_m, radius_m);
      if (!map.sigma_mm.back()) return std::nullopt;
    }
  }
  return map;
}

std::optional<double> ball_sigma_mm(const Camera& camera, const Eigen::MatrixXd& covariance) {
  constexpr double diameter_m = 0.070, range_m = 1;
  const auto map = ball_sigma_map(camera, covariance, diameter_m, range_m);
  if (!map) return std::nullopt;
  if (map->worst_mm()) return map->worst_mm();
  const ImageSize size = camera.size();
  const auto ray = camera.unproject({0.5 * (size.width_px - 1), 0.5 * (size.height_px - 1)});
  return ray ? CameraUncertainty(camera, covariance).ball_sigma_mm(*ray * range_m, 0.5 * diameter_m)
             : std::nullopt;
}

}  // namespace ballservo
