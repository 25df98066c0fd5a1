#include "app/comparison/estimators/circle_methods.hpp"

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

// Of the Jacobian whose (J'WJ)^-1 the covariance is, but for a factor.
double condition_of(const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly).eigenvalues();
  return std::sqrt(values[2] / values[0]);
}

std::optional<MethodFit> converged(MethodScene& scene, const RobustLoss& loss) {
  if (!scene.start()) return std::nullopt;
  const auto minimum = converge_circle(*scene.start(), scene.ring(), loss);
  if (!minimum) return std::nullopt;
  auto fit = scene.from_circle(minimum->circle);
  if (!fit) return std::nullopt;
  fit->iterations = minimum->convergence.iterations;
  fit->residual_px = minimum->convergence.residual_px;
  fit->condition = minimum->convergence.condition;
  fit->converged = minimum->convergence.converged;
  fit->arc = arc_of(minimum->circle, scene.ring());
  return fit;
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

std::optional<MethodFit> fit_paper_converged(MethodScene& scene) { return converged(scene, {}); }

std::optional<MethodFit> fit_paper_robust(MethodScene& scene) { return converged(scene, scene.task().loss); }

std::optional<MethodFit> fit_kasa(MethodScene& scene) { return algebraic(scene, kasa_circle(scene.ring())); }

std::optional<MethodFit> fit_taubin(MethodScene& scene) {
  return algebraic(scene, taubin_circle(scene.ring()));
}

}  // namespace ballservo
