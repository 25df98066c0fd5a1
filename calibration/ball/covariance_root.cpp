#include "calibration/ball/covariance_root.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/camera/files/camera_covariance.hpp"

namespace ballservo {

Eigen::MatrixXd covariance_root(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  Eigen::MatrixXd correlation = covariance;
  for (Eigen::Index i = 0; i < correlation.rows(); ++i)
    for (Eigen::Index j = 0; j < correlation.cols(); ++j)
      correlation(i, j) = sigma(i) > 0 && sigma(j) > 0 ? correlation(i, j) / (sigma(i) * sigma(j)) : 0;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(correlation);
  Eigen::MatrixXd root = solver.eigenvectors();
  for (Eigen::Index j = 0; j < root.cols(); ++j) {
    root.col(j) *= std::sqrt(std::max(0.0, solver.eigenvalues()(j)));
    root.col(j).array() *= sigma.array();
  }
  return root;
}

std::optional<std::vector<std::pair<Camera, Camera>>> changed_cameras(const Camera& camera,
                                                                      const Eigen::MatrixXd& covariance,
                                                                      double step) {
  std::vector<std::pair<Camera, Camera>> result;
  const Eigen::VectorXd parameters = parameter_vector(camera.parameters());
  const Eigen::MatrixXd root = covariance_root(covariance);
  for (Eigen::Index axis = 0; axis < root.cols(); ++axis) {
    if (!(root.col(axis).norm() > 0)) continue;
    const Eigen::VectorXd change = step * root.col(axis);
    try {
      result.emplace_back(Camera(with_parameter_vector(camera.parameters(), parameters + change)),
                          Camera(with_parameter_vector(camera.parameters(), parameters - change)));
    } catch (const InputError&) {
      return std::nullopt;
    }
  }
  return result;
}

}  // namespace ballservo
