#include "app/offline/cone_methods.hpp"

#include <algorithm>

#include "app/offline/method_scene.hpp"

namespace ballservo {
namespace {

// Of the points around the outline, those that are believed.
double arc_of(const std::vector<EdgePoint>& points) {
  constexpr double believed = 0.25;
  const auto count =
      std::count_if(points.begin(), points.end(), [](const EdgePoint& p) { return p.weight > believed; });
  return points.empty() ? 0 : static_cast<double>(count) / static_cast<double>(points.size());
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
  double condition = 0;
  while (taken < steps) {
    if (taken + 1 == steps) condition = linearise_cone(cone, edges->points).condition();
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
  fit->condition = condition;
  fit->arc = arc_of(edges->points);
  return fit;
}

std::optional<MethodFit> fit_sphere_converged(MethodScene& scene) { return converged(scene, {}); }

std::optional<MethodFit> fit_sphere_robust(MethodScene& scene) { return converged(scene, scene.task().loss); }

}  // namespace ballservo
