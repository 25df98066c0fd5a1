#include "app/comparison/estimators/converged_fits.hpp"

#include <ceres/ceres.h>

#include <Eigen/Eigenvalues>
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

ceres::LossFunction* loss_function(const RobustLoss& loss) {
  switch (loss.kind) {
    case RobustLossKind::huber:
      return new ceres::HuberLoss(loss.scale_px);
    case RobustLossKind::cauchy:
      return new ceres::CauchyLoss(loss.scale_px);
    case RobustLossKind::tukey:
      return new ceres::TukeyLoss(loss.scale_px);
    default:
      return nullptr;
  }
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
      rho = new ceres::ScaledLoss(loss_function(loss), weight, ceres::TAKE_OWNERSHIP);
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
    convergence.cost = 2 * summary.final_cost;
    convergence.iterations = summary.num_successful_steps + summary.num_unsuccessful_steps;
    const Linearisation end = linearise();
    convergence.converged = summary.termination_type == ceres::CONVERGENCE && has_no_slope(end);
    convergence.condition = condition_of(end.jacobian.transpose() * end.jacobian);
    return convergence;
  }

  // As Ceres' minimiser sees it: with a loss, its correction included.
  Linearisation linearise() {
    Linearisation at;
    std::vector<double> residuals;
    ceres::CRSMatrix jacobian;
    problem_.Evaluate({}, nullptr, &residuals, nullptr, &jacobian);
    at.residuals = Eigen::Map<Eigen::VectorXd>(residuals.data(), static_cast<Eigen::Index>(residuals.size()));
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    at.jacobian = Eigen::Map<Rows>(jacobian.values.data(), at.residuals.size(), 3);
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

// What a family of fits is: its unknowns, its points, and how far they lie from it.
using Unknowns = std::array<double, 3>;

Unknowns unknowns_of(const UndistortedCircle& circle) {
  return {circle.center_px.x(), circle.center_px.y(), circle.radius_px};
}
Unknowns unknowns_of(const TangentCone&) { return {0, 0, 0}; }

UndistortedCircle shape_at(const UndistortedCircle&, const Unknowns& at) { return {{at[0], at[1]}, at[2]}; }
TangentCone shape_at(const TangentCone& start, const Unknowns& at) {
  return moved(start, {at[0], at[1], at[2]});
}

bool is_finite(const UndistortedCircle& c) { return c.center_px.allFinite() && std::isfinite(c.radius_px); }
bool is_finite(const TangentCone& cone) { return cone.axis.allFinite() && std::isfinite(cone.alpha_rad); }
bool has_size(const UndistortedCircle& circle) { return circle.radius_px > 0; }
bool has_size(const TangentCone& cone) { return cone.alpha_rad > 0 && cone.alpha_rad < 1.5707; }

double distance_px(const UndistortedCircle& circle, const RingPixel& pixel) {
  return (pixel.position_px - circle.center_px).norm() - circle.radius_px;
}
double distance_px(const TangentCone& cone, const EdgePoint& edge) {
  return angle_outside(cone, edge.ray) * edge.px_per_rad;
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

template <class Shape, class Point>
std::optional<Converged<Shape>> minimum_near(const Shape& start, const std::vector<Point>& points,
                                             const RobustLoss& loss) {
  Problem problem(unknowns_of(start));
  add_points(problem, start, points, loss);
  if (problem.points() < 3) return std::nullopt;
  const auto convergence = problem.solve();
  if (!convergence) return std::nullopt;
  const Converged<Shape> fit{shape_at(start, problem.unknowns()), *convergence};
  if (!is_finite(fit.shape) || !has_size(fit.shape)) return std::nullopt;
  return fit;
}

}  // namespace

double condition_of(const Eigen::Matrix3d& normal) {
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(normal, Eigen::EigenvaluesOnly).eigenvalues();
  const bool regular = values[0] > std::numeric_limits<double>::epsilon() * values[2];
  return regular ? std::sqrt(values[2] / values[0]) : std::numeric_limits<double>::infinity();
}

template <class Shape, class Point>
std::optional<Converged<Shape>> converge(const Shape& start, const std::vector<Point>& points,
                                         const RobustLoss& loss) {
  if (!is_finite(start)) return std::nullopt;
  auto fit = minimum_near(start, points, loss);
  if (loss.kind != RobustLossKind::squares) {
    const auto squares = minimum_near(start, points, {});
    const auto other = squares ? minimum_near(squares->shape, points, loss) : squares;
    if (other && (!fit || other->convergence.cost < fit->convergence.cost * (1 - 1e-12))) fit = other;
  }
  if (!fit) return std::nullopt;
  double squares_px2 = 0, weights = 0;
  for (const Point& point : points) {
    if (!counts(point)) continue;
    const double off_px = distance_px(fit->shape, point);
    squares_px2 += point.weight * off_px * off_px;
    weights += point.weight;
  }
  fit->convergence.residual_px = std::sqrt(squares_px2 / weights);
  return fit;
}

template <class Shape, class Point>
Linearisation linearise(const Shape& at, const std::vector<Point>& points) {
  Problem problem(unknowns_of(at));
  add_points(problem, at, points, {});
  return problem.points() > 0 ? problem.linearise() : Linearisation{};
}

template std::optional<Converged<UndistortedCircle>> converge(const UndistortedCircle&,
                                                              const std::vector<RingPixel>&,
                                                              const RobustLoss&);
template std::optional<Converged<TangentCone>> converge(const TangentCone&, const std::vector<EdgePoint>&,
                                                        const RobustLoss&);
template Linearisation linearise(const UndistortedCircle&, const std::vector<RingPixel>&);
template Linearisation linearise(const TangentCone&, const std::vector<EdgePoint>&);

}  // namespace ballservo
