#include "calibration/camera/ball_uncertainty.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/camera/camera_covariance.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/files/fault.hpp"

namespace ballservo {
namespace {

constexpr int outline_points = 24, grid_steps = 8;
constexpr double step_sigmas = 0.05;  // small against one sigma, large against rounding

/// Columns l_i with sum l_i l_i' = covariance; of a matrix whose entries differ by orders of magnitude.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& covariance) {
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

std::optional<Eigen::Vector3d> ball_from_outline(const Camera& camera,
                                                 const std::vector<Eigen::Vector2d>& outline,
                                                 double radius_m) {
  std::vector<Eigen::Vector3d> rays;
  for (const Eigen::Vector2d& pixel : outline) {
    const auto ray = camera.unproject(pixel);
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
  }
  return sphere_from_rays(rays, radius_m);
}

bool inside(const std::vector<Eigen::Vector2d>& outline, ImageSize size) {
  return !outline.empty() && std::all_of(outline.begin(), outline.end(), [&](const Eigen::Vector2d& p) {
    return p.x() >= -0.5 && p.y() >= -0.5 && p.x() <= size.width_px - 0.5 && p.y() <= size.height_px - 0.5;
  });
}

}  // namespace

CameraUncertainty::CameraUncertainty(const Camera& camera, const Eigen::MatrixXd& covariance)
    : camera_(camera) {
  const Eigen::VectorXd parameters = parameter_vector(camera.parameters());
  const Eigen::MatrixXd root = square_root(covariance);
  for (Eigen::Index axis = 0; axis < root.cols(); ++axis) {
    if (!(root.col(axis).norm() > 0)) continue;
    const Eigen::VectorXd step = step_sigmas * root.col(axis);
    try {
      changed_.emplace_back(Camera(with_parameter_vector(camera.parameters(), parameters + step)),
                            Camera(with_parameter_vector(camera.parameters(), parameters - step)));
    } catch (const InputError&) {
      valid_ = false;
    }
  }
}

std::optional<Eigen::Matrix3d> CameraUncertainty::ball_covariance(const Eigen::Vector3d& p_C,
                                                                  double radius_m) const {
  const auto outline = project_outline(camera_, p_C, radius_m, outline_points);
  if (!valid_ || outline.empty()) return std::nullopt;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [above, below] : changed_) {
    const auto high = ball_from_outline(above, outline, radius_m);
    const auto low = ball_from_outline(below, outline, radius_m);
    if (!high || !low) return std::nullopt;
    const Eigen::Vector3d derivative = (*high - *low) / (2 * step_sigmas);
    sum += derivative * derivative.transpose();
  }
  if (!sum.allFinite()) return std::nullopt;
  return sum;
}

std::optional<double> ball_sigma_mm(const Camera& camera, const Eigen::MatrixXd& covariance,
                                    double diameter_m, double range_m) {
  const double radius_m = 0.5 * diameter_m;
  const ImageSize size = camera.size();
  const CameraUncertainty uncertainty(camera, covariance);
  const auto center_at = [&](double u, double v) -> std::optional<Eigen::Vector3d> {
    const auto ray = camera.unproject({u, v});
    if (!ray) return std::nullopt;
    return *ray * range_m;
  };
  std::vector<Eigen::Vector3d> centers;
  for (int i = 0; i <= grid_steps; ++i) {
    for (int j = 0; j <= grid_steps; ++j) {
      const auto p_C =
          center_at((size.width_px - 1.0) * i / grid_steps, (size.height_px - 1.0) * j / grid_steps);
      if (p_C && inside(project_outline(camera, *p_C, radius_m, outline_points), size))
        centers.push_back(*p_C);
    }
  }
  if (centers.empty()) {
    const auto p_C = center_at(0.5 * size.width_px, 0.5 * size.height_px);
    if (!p_C) return std::nullopt;
    centers.push_back(*p_C);
  }
  double worst = 0;
  for (const Eigen::Vector3d& p_C : centers) {
    const auto covariance_m2 = uncertainty.ball_covariance(p_C, radius_m);
    if (!covariance_m2) return std::nullopt;
    worst = std::max(worst, covariance_m2->trace());
  }
  return 1e3 * std::sqrt(worst);
}

}  // namespace ballservo
