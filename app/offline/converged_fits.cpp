#include "app/offline/converged_fits.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// sqrt(w) C of one pixel. The circle's radius is in units of pixels, as its centre is.
struct CircleResidual {
  Eigen::Vector2d position_px;
  double root_weight;

  template <typename T>
  bool operator()(const T* circle, T* residual) const {
    using std::sqrt;
    const T dx = circle[0] - position_px.x(), dy = circle[1] - position_px.y();
    residual[0] = root_weight * (sqrt(dx * dx + dy * dy) - circle[2]);
    return true;
  }
};

// sqrt(w) angle_outside px_per_rad / sigma of one edge point, by the (turn, turn, change of alpha) that
// `moved` takes.
struct ConeResidual {
  TangentCone start;
  Eigen::Matrix<double, 3, 2> basis;
  Eigen::Vector3d ray;
  double scale;

  template <typename T>
  bool operator()(const T* step, T* residual) const {
    using std::atan2;
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Vector axis =
        start.axis.cast<T>() + basis.col(0).cast<T>() * step[0] + basis.col(1).cast<T>() * step[1];
    const Vector direction = ray.cast<T>();
    // The angle does not depend on the axis's length, so it needs no normalisation.
    residual[0] =
        scale * (atan2(axis.cross(direction).norm(), axis.dot(direction)) - start.alpha_rad - step[2]);
    return true;
  }
};

std::optional<Convergence> solve(ceres::Problem& problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-13;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable()) return std::nullopt;
  Convergence convergence;
  // Ceres' cost is half the sum of squares.
  convergence.start_cost = 2 * summary.initial_cost;
  convergence.cost = 2 * summary.final_cost;
  convergence.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
  convergence.converged = summary.termination_type == ceres::CONVERGENCE;
  return convergence;
}

bool counts(const RingPixel& pixel) {
  return pixel.weight > 0 && std::isfinite(pixel.weight) && pixel.position_px.allFinite();
}

bool counts(const EdgePoint& edge) {
  return edge.weight > 0 && std::isfinite(edge.weight * edge.px_per_rad / edge.sigma_px) &&
         edge.ray.allFinite();
}

}  // namespace

double circle_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  double cost = 0;
  for (const RingPixel& pixel : ring) {
    if (!counts(pixel)) continue;
    const double distance = (pixel.position_px - circle.center_px).norm() - circle.radius_px;
    cost += pixel.weight * distance * distance;
  }
  return cost;
}

std::optional<ConvergedCircle> converge_circle(const UndistortedCircle& start,
                                               const std::vector<RingPixel>& ring) {
  if (!start.center_px.allFinite() || !std::isfinite(start.radius_px)) return std::nullopt;
  ceres::Problem problem;
  std::array<double, 3> circle{start.center_px.x(), start.center_px.y(), start.radius_px};
  double weights = 0;
  int used = 0;
  for (const RingPixel& pixel : ring) {
    // A pixel right at the centre has no direction to pull in: perception's step leaves it out too.
    if (!counts(pixel) || pixel.position_px == start.center_px) continue;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CircleResidual, 1, 3>(
                                 new CircleResidual{pixel.position_px, std::sqrt(pixel.weight)}),
                             nullptr, circle.data());
    weights += pixel.weight;
    ++used;
  }
  if (used < 3) return std::nullopt;
  const auto convergence = solve(problem);
  if (!convergence) return std::nullopt;
  ConvergedCircle fit{{{circle[0], circle[1]}, circle[2]}, *convergence};
  if (!fit.circle.center_px.allFinite() || !(fit.circle.radius_px > 0)) return std::nullopt;
  fit.convergence.residual_px = std::sqrt(fit.convergence.cost / weights);
  return fit;
}

double cone_cost(const TangentCone& cone, const std::vector<EdgePoint>& edges) {
  double cost = 0;
  for (const EdgePoint& edge : edges) {
    if (!counts(edge)) continue;
    const double residual = angle_outside(cone, edge.ray) * edge.px_per_rad / edge.sigma_px;
    cost += edge.weight * residual * residual;
  }
  return cost;
}

std::optional<ConvergedCone> converge_cone(const TangentCone& start, const std::vector<EdgePoint>& edges) {
  if (!start.axis.allFinite() || !std::isfinite(start.alpha_rad)) return std::nullopt;
  ceres::Problem problem;
  std::array<double, 3> step{0, 0, 0};
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(start.axis);
  int used = 0;
  for (const EdgePoint& edge : edges) {
    if (!counts(edge) || edge.ray.cross(start.axis).norm() == 0) continue;
    const double scale = std::sqrt(edge.weight) * edge.px_per_rad / edge.sigma_px;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ConeResidual, 1, 3>(new ConeResidual{start, basis, edge.ray, scale}),
        nullptr, step.data());
    ++used;
  }
  if (used < 3) return std::nullopt;
  const auto convergence = solve(problem);
  if (!convergence) return std::nullopt;
  ConvergedCone fit{moved(start, {step[0], step[1], step[2]}), *convergence};
  if (!fit.cone.axis.allFinite() || !(fit.cone.alpha_rad > 0) || !(fit.cone.alpha_rad < 1.5707))
    return std::nullopt;
  double squares_px2 = 0, weights = 0;
  for (const EdgePoint& edge : edges) {
    if (!counts(edge)) continue;
    const double residual_px = angle_outside(fit.cone, edge.ray) * edge.px_per_rad;
    squares_px2 += edge.weight * residual_px * residual_px;
    weights += edge.weight;
  }
  fit.convergence.residual_px = std::sqrt(squares_px2 / weights);
  return fit;
}

}  // namespace ballservo
