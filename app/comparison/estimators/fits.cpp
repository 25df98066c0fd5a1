#include "app/comparison/estimators/fits.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "app/comparison/estimators/algebraic_circles.hpp"
#include "app/comparison/estimators/method_scene.hpp"

namespace ballservo {
namespace {

// Of 36 sectors, those that hold a fair share of the ring's weight: a quarter of what an even spread would
// give.
double arc_of(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  constexpr int sectors = 36;
  constexpr double fair = 0.25;
  std::array<double, sectors> weights{};
  double sum = 0;
  for (const RingPixel& pixel : ring) {
    const Eigen::Vector2d d = pixel.position_px - circle.center_px;
    const double turn = std::atan2(d.y(), d.x()) / (2 * M_PI) + 0.5;
    const auto sector =
        static_cast<std::size_t>(std::clamp(static_cast<int>(turn * sectors), 0, sectors - 1));
    weights[sector] += pixel.weight;
    sum += pixel.weight;
  }
  const auto seen =
      std::count_if(weights.begin(), weights.end(), [&](double w) { return w > fair * sum / sectors; });
  return static_cast<double>(seen) / sectors;
}

// Of the points around the outline, those that are believed.
double arc_of(const std::vector<EdgePoint>& points) {
  constexpr double believed = 0.25;
  const auto count =
      std::count_if(points.begin(), points.end(), [](const EdgePoint& p) { return p.weight > believed; });
  return points.empty() ? 0 : static_cast<double>(count) / static_cast<double>(points.size());
}

// Of a 3 x 3 matrix, for a Jacobian whose normal matrix it is, or the inverse of that.
double condition_of(const Eigen::Matrix3d& normal) {
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normal, Eigen::EigenvaluesOnly).eigenvalues();
  return std::sqrt(values[2] / values[0]);
}

// Of the weighted angles outside the cone: turning the axis towards a ray shrinks its angle.
Eigen::Matrix3d normal_matrix(const TangentCone& cone, const std::vector<EdgePoint>& points) {
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(cone.axis);
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  for (const EdgePoint& point : points) {
    const double scale = point.px_per_rad / point.sigma_px;
    if (!(point.weight > 0) || !std::isfinite(scale)) continue;
    const Eigen::Vector2d towards = (basis.transpose() * point.ray).normalized();
    const Eigen::Vector3d row(towards.x(), towards.y(), 1);
    normal += point.weight * scale * scale * row * row.transpose();
  }
  return normal;
}

// A converged fit, as the other methods state theirs.
std::optional<MethodFit> with(std::optional<MethodFit> fit, const Convergence& convergence, double arc) {
  if (!fit) return std::nullopt;
  fit->iterations = convergence.iterations;
  fit->residual_px = convergence.residual_px;
  fit->condition = convergence.condition;
  fit->converged = convergence.converged;
  fit->arc = arc;
  return fit;
}

RobustLoss loss_of(const MethodScene& scene, bool robust) {
  return robust ? scene.task().loss : RobustLoss{};
}

std::optional<MethodFit> algebraic(MethodScene& scene, const std::optional<UndistortedCircle>& circle) {
  if (!circle) return std::nullopt;
  auto fit = scene.from_circle(*circle);
  if (fit) fit->arc = arc_of(*circle, scene.ring());
  return fit;
}

}  // namespace

std::optional<MethodFit> fit_vote(MethodScene& scene) {
  return scene.start() ? scene.from_circle(*scene.start()) : std::nullopt;
}

std::optional<MethodFit> fit_paper_steps(MethodScene& scene, int steps, bool reselect) {
  if (!scene.start()) return std::nullopt;
  std::vector<RingPixel> ring = scene.ring();
  UndistortedCircle circle = *scene.start();
  std::optional<CircleFit> last;
  int taken = 0;
  while (taken < steps) {
    if (reselect && taken > 0) select_ring_pixels(scene.bgr(), scene.rays(), circle, ring);
    const auto step = one_gauss_newton_step(circle, ring);
    if (!step) break;
    last = step;
    circle = step->circle;
    ++taken;
  }
  if (!last) return std::nullopt;
  auto fit = scene.from_circle(circle);
  if (!fit) return std::nullopt;
  fit->iterations = taken;
  fit->residual_px = last->residual_px;
  fit->step_px = last->step_px;
  if (const auto next = one_gauss_newton_step(circle, ring)) fit->next_step_px = next->step_px;
  fit->condition = condition_of(last->covariance_px2);
  fit->arc = arc_of(circle, ring);
  return fit;
}

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
  fit->condition = condition_of(normal_matrix(cone, edges->points));
  fit->arc = arc_of(edges->points);
  return fit;
}

std::optional<MethodFit> fit_paper_converged(MethodScene& scene, bool robust) {
  if (!scene.start()) return std::nullopt;
  const auto minimum = converge(*scene.start(), scene.ring(), loss_of(scene, robust));
  if (!minimum) return std::nullopt;
  return with(scene.from_circle(minimum->shape), minimum->convergence, arc_of(minimum->shape, scene.ring()));
}

std::optional<MethodFit> fit_sphere_converged(MethodScene& scene, bool robust) {
  const auto& edges = scene.edges();
  if (!edges) return std::nullopt;
  const auto minimum = converge(edges->start, edges->points, loss_of(scene, robust));
  if (!minimum) return std::nullopt;
  return with(scene.from_cone(minimum->shape), minimum->convergence, arc_of(edges->points));
}

std::optional<MethodFit> fit_kasa(MethodScene& scene) { return algebraic(scene, kasa_circle(scene.ring())); }

std::optional<MethodFit> fit_taubin(MethodScene& scene) {
  return algebraic(scene, taubin_circle(scene.ring()));
}

}  // namespace ballservo
