#include "app/comparison/estimators/converged_fits.hpp"

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// Cosine between the residuals and a column of the Jacobian; of a robust cost, which is reached step by step.
constexpr double perpendicular = 1e-6, nearly_perpendicular = 1e-4;
constexpr double no_residual = 1e-12;  // of the residuals' norm against the points' weights: an exact fit

// sqrt(w) C of one pixel. The circle's radius is in units of pixels, as its centre is.
struct CircleResidual {
  Eigen::Vector2d position_px;
  double scale;

  template <typename T>
  bool operator()(const T* circle, T* residual) const {
    using std::sqrt;
    const T dx = circle[0] - position_px.x(), dy = circle[1] - position_px.y();
    residual[0] = scale * (sqrt(dx * dx + dy * dy) - circle[2]);
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

ceres::LossFunction* loss_function(const RobustLoss& loss, double weight) {
  ceres::LossFunction* rho = nullptr;
  switch (loss.kind) {
    case RobustLossKind::squares:
      break;
    case RobustLossKind::huber:
      rho = new ceres::HuberLoss(loss.scale_px);
      break;
    case RobustLossKind::cauchy:
      rho = new ceres::CauchyLoss(loss.scale_px);
      break;
    case RobustLossKind::tukey:
      rho = new ceres::TukeyLoss(loss.scale_px);
      break;
  }
  return new ceres::ScaledLoss(rho, weight, ceres::TAKE_OWNERSHIP);
}

// Three unknowns and the points that pull at them.
class Problem {
 public:
  explicit Problem(const std::array<double, 3>& start) : unknowns_(start) {}

  // Without a loss the weight is the residual's own: sqrt(w) r.
  template <class Residual>
  void add(Residual residual, double weight, const RobustLoss& loss) {
    ceres::LossFunction* rho = nullptr;
    if (loss.kind == RobustLossKind::squares) {
      residual.scale *= std::sqrt(weight);
    } else {
      rho = loss_function(loss, weight);
      robust_ = true;
    }
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Residual, 1, 3>(new Residual(std::move(residual))), rho,
        unknowns_.data());
    ++points_;
    weights_ += weight;
  }
  int points() const { return points_; }
  const std::array<double, 3>& unknowns() const { return unknowns_; }

  std::optional<Convergence> solve() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.num_threads = 1;
    options.max_num_iterations = 200;
    // A robust cost has no residual that vanishes: Gauss-Newton creeps towards its minimum.
    options.function_tolerance = robust_ ? 1e-11 : 1e-15;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = robust_ ? 1e-9 : 1e-13;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    if (!summary.IsSolutionUsable()) return std::nullopt;
    Convergence convergence;
    // Ceres' cost is half the sum of squares.
    convergence.start_cost = 2 * summary.initial_cost;
    convergence.cost = 2 * summary.final_cost;
    convergence.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
    const Linearisation end = linearise();
    convergence.converged = summary.termination_type == ceres::CONVERGENCE && has_no_slope(end);
    convergence.condition = end.condition();
    return convergence;
  }

  // As Ceres' minimiser sees it: with a loss, its correction included.
  Linearisation linearise() {
    Linearisation at;
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
    problem_.Evaluate({}, nullptr, &residuals, nullptr, &jacobian);
    at.residuals = Eigen::Map<Eigen::VectorXd>(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
    at.jacobian.resize(static_cast<Eigen::Index>(residuals.size()), 3);
    for (Eigen::Index row = 0; row < at.jacobian.rows(); ++row) {
      for (Eigen::Index column = 0; column < 3; ++column)
        at.jacobian(row, column) = jacobian.values[static_cast<std::size_t>(3 * row + column)];
    }
    return at;
  }

 private:
  bool has_no_slope(const Linearisation& at) const {
    const double size = at.residuals.norm();
    if (size <= no_residual * std::sqrt(weights_)) return true;
    for (Eigen::Index column = 0; column < 3; ++column) {
      const double cosine =
          at.jacobian.col(column).dot(at.residuals) / (at.jacobian.col(column).norm() * size);
      if (!(std::abs(cosine) < (robust_ ? nearly_perpendicular : perpendicular))) return false;
    }
    return true;
  }

  std::array<double, 3> unknowns_;
  ceres::Problem problem_;
  int points_ = 0;
  double weights_ = 0;
  bool robust_ = false;
};

bool counts(const RingPixel& pixel) {
  return pixel.weight > 0 && std::isfinite(pixel.weight) && pixel.position_px.allFinite();
}

bool counts(const EdgePoint& edge) {
  return edge.weight > 0 && std::isfinite(edge.weight * edge.px_per_rad / edge.sigma_px) &&
         edge.ray.allFinite();
}

void add_points(Problem& problem, const UndistortedCircle& start, const std::vector<RingPixel>& ring,
                const RobustLoss& loss) {
  for (const RingPixel& pixel : ring) {
    // A pixel right at the centre has no direction to pull in: perception's step leaves it out too.
    if (!counts(pixel) || pixel.position_px == start.center_px) continue;
    problem.add(CircleResidual{pixel.position_px, 1}, pixel.weight, loss);
  }
}

void add_points(Problem& problem, const TangentCone& start, const std::vector<EdgePoint>& edges,
                const RobustLoss& loss) {
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(start.axis);
  const bool robust = loss.kind != RobustLossKind::squares;
  for (const EdgePoint& edge : edges) {
    const bool known =
        robust ? std::isfinite(edge.px_per_rad / edge.sigma_px) && edge.ray.allFinite() : counts(edge);
    if (!known || edge.ray.cross(start.axis).norm() == 0) continue;
    // A loss wants the residual in px, and the points' sigmas as weights.
    const double inverse = 1 / edge.sigma_px;
    if (robust) {
      problem.add(ConeResidual{start, basis, edge.ray, edge.px_per_rad}, inverse * inverse, loss);
    } else {
      problem.add(ConeResidual{start, basis, edge.ray, edge.px_per_rad * inverse}, edge.weight, loss);
    }
  }
}

std::optional<ConvergedCircle> circle_from(const UndistortedCircle& start, const std::vector<RingPixel>& ring,
                                           const RobustLoss& loss) {
  Problem problem({start.center_px.x(), start.center_px.y(), start.radius_px});
  add_points(problem, start, ring, loss);
  if (problem.points() < 3) return std::nullopt;
  const auto convergence = problem.solve();
  if (!convergence) return std::nullopt;
  const auto& [x, y, r] = problem.unknowns();
  ConvergedCircle fit{{{x, y}, r}, *convergence};
  if (!fit.circle.center_px.allFinite() || !(fit.circle.radius_px > 0)) return std::nullopt;
  return fit;
}

std::optional<ConvergedCone> cone_from(const TangentCone& start, const std::vector<EdgePoint>& edges,
                                       const RobustLoss& loss) {
  Problem problem({0, 0, 0});
  add_points(problem, start, edges, loss);
  if (problem.points() < 3) return std::nullopt;
  const auto convergence = problem.solve();
  if (!convergence) return std::nullopt;
  const auto& [turn_1, turn_2, widening] = problem.unknowns();
  ConvergedCone fit{moved(start, {turn_1, turn_2, widening}), *convergence};
  if (!fit.cone.axis.allFinite() || !(fit.cone.alpha_rad > 0) || !(fit.cone.alpha_rad < 1.5707))
    return std::nullopt;
  return fit;
}

// The lower of two minima that were reached from different starts.
template <class Fit>
void keep_lower(std::optional<Fit>& best, const std::optional<Fit>& other) {
  if (!other) return;
  const int starts = (best ? best->convergence.starts : 0) + 1;
  const double start_cost = best ? best->convergence.start_cost : other->convergence.start_cost;
  if (!best || other->convergence.cost < best->convergence.cost * (1 - 1e-12)) best = other;
  best->convergence.starts = starts;
  best->convergence.start_cost = start_cost;
}

}  // namespace

std::string_view robust_loss_name(RobustLossKind kind) {
  constexpr std::array<std::string_view, 4> names{"squares", "huber", "cauchy", "tukey"};
  return names[static_cast<std::size_t>(kind)];
}

double Linearisation::condition() const {
  if (jacobian.rows() < 3 || !jacobian.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::Matrix3d normal = jacobian.transpose() * jacobian;
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normal, Eigen::EigenvaluesOnly).eigenvalues();
  return values[0] > 0 ? std::sqrt(values[2] / values[0]) : std::numeric_limits<double>::infinity();
}

double circle_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  double cost = 0;
  for (const RingPixel& pixel : ring) {
    if (!counts(pixel)) continue;
    const double distance = (pixel.position_px - circle.center_px).norm() - circle.radius_px;
    cost += pixel.weight * distance * distance;
  }
  return cost;
}

Linearisation linearise_circle(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  Problem problem({circle.center_px.x(), circle.center_px.y(), circle.radius_px});
  add_points(problem, circle, ring, {});
  return problem.points() > 0 ? problem.linearise() : Linearisation{};
}

std::optional<ConvergedCircle> converge_circle(const UndistortedCircle& start,
                                               const std::vector<RingPixel>& ring, const RobustLoss& loss) {
  if (!start.center_px.allFinite() || !std::isfinite(start.radius_px)) return std::nullopt;
  auto fit = circle_from(start, ring, loss);
  if (loss.kind != RobustLossKind::squares) {
    if (const auto squares = circle_from(start, ring, {}))
      keep_lower(fit, circle_from(squares->circle, ring, loss));
  }
  if (!fit) return std::nullopt;
  double weights = 0;
  for (const RingPixel& pixel : ring) weights += counts(pixel) ? pixel.weight : 0;
  fit->convergence.residual_px = std::sqrt(circle_cost(fit->circle, ring) / weights);
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

Linearisation linearise_cone(const TangentCone& cone, const std::vector<EdgePoint>& edges) {
  Problem problem({0, 0, 0});
  add_points(problem, cone, edges, {});
  return problem.points() > 0 ? problem.linearise() : Linearisation{};
}

std::optional<ConvergedCone> converge_cone(const TangentCone& start, const std::vector<EdgePoint>& edges,
                                           const RobustLoss& loss) {
  if (!start.axis.allFinite() || !std::isfinite(start.alpha_rad)) return std::nullopt;
  auto fit = cone_from(start, edges, loss);
  if (loss.kind != RobustLossKind::squares) {
    if (const auto squares = cone_from(start, edges, {}))
      keep_lower(fit, cone_from(squares->cone, edges, loss));
  }
  if (!fit) return std::nullopt;
  double squares_px2 = 0, weights = 0;
  for (const EdgePoint& edge : edges) {
    if (!counts(edge)) continue;
    const double residual_px = angle_outside(fit->cone, edge.ray) * edge.px_per_rad;
    squares_px2 += edge.weight * residual_px * residual_px;
    weights += edge.weight;
  }
  fit->convergence.residual_px = std::sqrt(squares_px2 / weights);
  return fit;
}

}  // namespace ballservo
