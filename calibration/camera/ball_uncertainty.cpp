#include "calibration/camera/ball_uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "calibration/camera/covariance_root.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr int outline_points = 24, grid_steps = 8;
constexpr double step_sigmas = 0.05;  // small against one sigma, large against rounding

}  // namespace

CameraUncertainty::CameraUncertainty(const Camera& camera, const Eigen::MatrixXd& covariance)
    : camera_(camera) {
  auto changed = changed_cameras(camera, covariance, step_sigmas);
  valid_ = changed.has_value();
  if (changed) changed_ = std::move(*changed);
}

std::optional<Eigen::Matrix3d> CameraUncertainty::ball_covariance(const Eigen::Vector3d& p_C,
                                                                  double radius_m) const {
  const auto outline = project_outline(camera_, p_C, radius_m, outline_points);
  if (!valid_ || outline.empty()) return std::nullopt;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [above, below] : changed_) {
    const auto high = sphere_from_outline(above, outline, radius_m);
    const auto low = sphere_from_outline(below, outline, radius_m);
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
      if (p_C && is_inside_picture(project_outline(camera, *p_C, radius_m, outline_points), size))
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
