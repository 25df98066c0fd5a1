#include "app/comparison/estimators/fits.hpp"

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
double arc_of(const TangentCone&, const std::vector<EdgePoint>& points) {
  constexpr double believed = 0.25;
  const auto count =
      std::count_if(points.begin(), points.end(), [](const EdgePoint& p) { return p.weight > believed; });
  return points.empty() ? 0 : static_cast<double>(count) / static_cast<double>(points.size());
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

// Of the last step's weighted Jacobian: the covariance is the inverse of its normal matrix.
double condition_after(const CircleFit& last, const std::vector<RingPixel>&) {
  return condition_of(last.covariance_px2);
}
double condition_after(const ConeFit& last, const std::vector<EdgePoint>& points) {
  return condition_of(normal_matrix(last.cone, points));
}

const UndistortedCircle& shape_of(const CircleFit& step) { return step.circle; }
const TangentCone& shape_of(const ConeFit& step) { return step.cone; }

// Gauss-Newton steps until as many are taken or one fails; `reselect` may choose the points anew around a
// step's shape.
template <class Shape, class Points, class Reselect>
std::optional<MethodFit> take_steps(const MethodScene& scene, Shape shape, Points& points, int steps,
                                    Reselect reselect) {
  decltype(one_gauss_newton_step(shape, points)) last;
  int taken = 0;
  for (; taken < steps; ++taken) {
    if (taken > 0) reselect(shape);
    const auto step = one_gauss_newton_step(shape, points);
    if (!step) break;
    last = step;
    shape = shape_of(*step);
  }
  if (!last) return std::nullopt;
  auto fit = scene.answer(shape);
  if (!fit) return std::nullopt;
  fit->iterations = taken;
  fit->residual_px = last->residual_px;
  fit->step_px = last->step_px;
  if (const auto next = one_gauss_newton_step(shape, points)) fit->next_step_px = next->step_px;
  fit->condition = condition_after(*last, points);
  fit->arc = arc_of(shape, points);
  return fit;
}

template <class Shape, class Points>
std::optional<MethodFit> at_minimum(const MethodScene& scene, const Shape& start, const Points& points,
                                    bool robust) {
  const auto minimum = converge(start, points, robust ? scene.task().loss : RobustLoss{});
  if (!minimum) return std::nullopt;
  auto fit = scene.answer(minimum->shape);
  if (!fit) return std::nullopt;
  fit->iterations = minimum->convergence.iterations;
  fit->residual_px = minimum->convergence.residual_px;
  fit->condition = minimum->convergence.condition;
  fit->converged = minimum->convergence.converged;
  fit->arc = arc_of(minimum->shape, points);
  return fit;
}

std::optional<MethodFit> algebraic(MethodScene& scene, const std::optional<UndistortedCircle>& circle) {
  if (!circle) return std::nullopt;
  auto fit = scene.answer(*circle);
  if (fit) fit->arc = arc_of(*circle, scene.ring());
  return fit;
}

}  // namespace

std::optional<MethodFit> fit_vote(MethodScene& scene) {
  return scene.start() ? scene.answer(*scene.start()) : std::nullopt;
}

std::optional<MethodFit> fit_paper_steps(MethodScene& scene, int steps, bool reselect) {
  if (!scene.start()) return std::nullopt;
  std::vector<RingPixel> ring = scene.ring();
  return take_steps(scene, *scene.start(), ring, steps, [&](const UndistortedCircle& circle) {
    if (reselect) select_ring_pixels(scene.bgr(), scene.rays(), circle, ring);
  });
}

std::optional<MethodFit> fit_sphere_steps(MethodScene& scene, int steps) {
  const auto& edges = scene.edges();
  if (!edges) return std::nullopt;
  return take_steps(scene, edges->start, edges->points, steps, [](const TangentCone&) {});
}

std::optional<MethodFit> fit_paper_converged(MethodScene& scene, bool robust) {
  if (!scene.start()) return std::nullopt;
  return at_minimum(scene, *scene.start(), scene.ring(), robust);
}

std::optional<MethodFit> fit_sphere_converged(MethodScene& scene, bool robust) {
  const auto& edges = scene.edges();
  if (!edges) return std::nullopt;
  return at_minimum(scene, edges->start, edges->points, robust);
}

std::optional<MethodFit> fit_kasa(MethodScene& scene) { return algebraic(scene, kasa_circle(scene.ring())); }

std::optional<MethodFit> fit_taubin(MethodScene& scene) {
  return algebraic(scene, taubin_circle(scene.ring()));
}

}  // namespace ballservo
