#include "app/comparison/estimators/cone_methods.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "app/comparison/estimators/method_scene.hpp"

namespace ballservo {
namespace {

// Of the points around the outline, those that are believed.
double arc_of(const std::vector<EdgePoint>& points) {
  constexpr double believed = 0.25;
  const auto count =
      std::count_if(points.begin(), points.end(), [](const EdgePoint& p) { return p.weight > believed; });
  return points.empty() ? 0 : static_cast<double>(count) / static_cast<double>(points.size());
}

// Of the weighted Jacobian of the angles outside the cone: turning the axis towards a ray shrinks its angle.
double condition_of(const TangentCone& cone, const std::vector<EdgePoint>& points) {
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const EdgePoint& point : points) {
    const double scale = point.px_per_rad / point.sigma_px;
    if (!(point.weight > 0) || !std::isfinite(scale)) continue;
    const Eigen::Vector2d towards = (basis.transpose() * point.ray).normalized();
    const Eigen::Vector3d row(towards.x(), towards.y(), 1);
    normal += point.weight * scale * scale * row * row.transpose();
  }
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normal, Eigen::EigenvaluesOnly).eigenvalues();
  return std::sqrt(values[2] / values[0]);
}

std::optional<MethodFit> converged(MethodScene& scene, const RobustLoss& loss) {
  const auto& edges = scene.edges();
  if (!edges) return std::nullopt;
  const auto minimum = converge_cone(edges->start, edges->points, loss);
  if (!minimum) return std::nullopt;
  auto fit = scene.from_cone(minimum->cone);
  if (!fit) return std::nullopt;
  fit->iterations = minimum->convergence.iterations;
  fit->residual_px = minimum->convergence.residual_px;
  fit->condition = minimum->convergence.condition;
  fit->converged = minimum->convergence.converged;
  fit->arc = arc_of(edges->points);
  return fit;
}

}  // namespace

std::optional<MethodFit> fit_sphere_steps(MethodScene& scene, int steps) {
  const auto& edges = scene.edges();
  if (!edges) return std::nullopt;
  TangentCone cone = edges->start;
  std::optional<ConeFit> last;
  int taken = 0;
  while (taken < steps) {
    const auto step = one_gauss_newton_step(cone, edges->points);
    if (!step) break;
    last = step;
    cone = step->cone;
    ++taken;
  }
  if (!last) return std::nullopt;
  auto fit = scene.from_cone(cone);
  if (!fit) return std::nullopt;
  fit->iterations = taken;
  fit->residual_px = last->residual_px;
  fit->step_px = last->step_px;
  if (const auto next = one_gauss_newton_step(cone, edges->points)) fit->next_step_px = next->step_px;
  fit->condition = condition_of(cone, edges->points);
  fit->arc = arc_of(edges->points);
  return fit;
}

std::optional<MethodFit> fit_sphere_converged(MethodScene& scene) { return converged(scene, {}); }

std::optional<MethodFit> fit_sphere_robust(MethodScene& scene) { return converged(scene, scene.task().loss); }

}  // namespace ballservo
