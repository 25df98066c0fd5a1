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

std::optional<double> ball_sigma_mm(const Camera& camera, const Eigen::MatrixXd& covariance,
                                    double diameter_m, double range_m) {
  const double radius_m = 0.5 * diameter_m;
  const ImageSize size = camera.size();
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  const auto outline_at = [&](double u, double v) {
    const auto ray = camera.unproject({u, v});
    return ray ? project_outline(camera, *ray * range_m, radius_m, outline_points)
               : std::vector<Eigen::Vector2d>{};
  };
  for (int i = 0; i <= grid_steps; ++i) {
    for (int j = 0; j <= grid_steps; ++j) {
      auto outline =
          outline_at((size.width_px - 1.0) * i / grid_steps, (size.height_px - 1.0) * j / grid_steps);
      if (inside(outline, size)) outlines.push_back(std::move(outline));
    }
  }
  if (outlines.empty()) outlines.push_back(outline_at(0.5 * size.width_px, 0.5 * size.height_px));
  if (outlines.front().empty()) return std::nullopt;

  const Eigen::VectorXd parameters = parameter_vector(camera.parameters());
  const Eigen::MatrixXd root = square_root(covariance);
  std::vector<double> traces(outlines.size(), 0.0);
  for (Eigen::Index axis = 0; axis < root.cols(); ++axis) {
    if (!(root.col(axis).norm() > 0)) continue;
    const Eigen::VectorXd step = step_sigmas * root.col(axis);
    try {
      const Camera above(with_parameter_vector(camera.parameters(), parameters + step));
      const Camera below(with_parameter_vector(camera.parameters(), parameters - step));
      for (std::size_t i = 0; i < outlines.size(); ++i) {
        const auto high = ball_from_outline(above, outlines[i], radius_m);
        const auto low = ball_from_outline(below, outlines[i], radius_m);
        if (!high || !low) return std::nullopt;
        traces[i] += ((*high - *low) / (2 * step_sigmas)).squaredNorm();
      }
    } catch (const InputError&) {
      return std::nullopt;  // a parameter is so uncertain that a twentieth of its sigma leaves what is valid
    }
  }
  const double worst = *std::max_element(traces.begin(), traces.end());
  if (!std::isfinite(worst)) return std::nullopt;
  return 1e3 * std::sqrt(worst);
}

}  // namespace ballservo
