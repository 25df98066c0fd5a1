#include "perception/outline/cone_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/base/statistics.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

// What the model of the edge leaves out (a terminator near the limb, a lamp from one side, texture) moves the
// outline as a whole, which the scatter of its points cannot show; the less the limb bends, the less. Times
// the radius (px), of each unknown: measured on rendered and painted balls in lights from all sides.
constexpr double common_error_px2 = 0.38;
constexpr int reweightings = 6;
constexpr double tukey = 4.685;  // 95 % efficient for Gaussian residuals

using Row = Eigen::Matrix<double, 5, 1>;

// Row of the Jacobian of the residual by (turn 1, turn 2, alpha, oval cos, oval sin): turning the axis
// towards the ray shrinks its angle.
Row jacobian_row(const Eigen::Matrix<double, 3, 2>& basis, const Eigen::Vector3d& ray) {
  const Eigen::Vector2d across = basis.transpose() * ray;
  const double length = across.norm();
  const Eigen::Vector2d e = length > 0 ? (across / length).eval() : Eigen::Vector2d(0, 0);
  Row row;
  row << -e.x(), -e.y(), -1, -(e.x() * e.x() - e.y() * e.y()), -2 * e.x() * e.y();
  return row;
}

// Of the next step from a cone of `alpha_rad`, after the steps `so_far`.
class NormalEquations {
 public:
  // The oval's two unknowns take part only where it has a sigma (rad).
  NormalEquations(double oval_sigma_rad, const KnownAngle& known, double alpha_rad, const Row& so_far)
      : unknowns_(oval_sigma_rad > 0 ? 5 : 3) {
    const auto believe = [&](int unknown, double step, double sigma) {
      if (!(sigma > 0)) return;
      matrix_(unknown, unknown) = 1 / (sigma * sigma);
      right_(unknown) = matrix_(unknown, unknown) * step;
    };
    believe(2, known.alpha_rad - (alpha_rad + so_far(2)), known.sigma_rad);
    for (const int oval : {3, 4}) believe(oval, -so_far(oval), oval_sigma_rad);
  }
  void add(const Row& row, double residual, double weight) {
    if (!(weight > 0) || !std::isfinite(residual)) return;
    if (unknowns_ == 3) {
      matrix_.topLeftCorner<3, 3>() += weight * row.head<3>() * row.head<3>().transpose();
      right_.head<3>() -= weight * residual * row.head<3>();
    } else {
      matrix_ += weight * row * row.transpose();
      right_ -= weight * residual * row;
    }
    ++used_;
  }
  std::optional<Row> solve() const {
    if (used_ < unknowns_) return std::nullopt;
    const Eigen::LDLT<Matrix> ldlt(matrix_.topLeftCorner(unknowns_, unknowns_));
    const auto d = ldlt.vectorD();
    if (!(d.minCoeff() > 1e-9 * d.maxCoeff())) return std::nullopt;
    Row step = Row::Zero();
    step.head(unknowns_) = ldlt.solve(right_.head(unknowns_));
    if (!step.allFinite()) return std::nullopt;
    return step;
  }
  /// Of (turn 1, turn 2, alpha), whatever the oval is.
  Eigen::Matrix3d covariance() const {
    return matrix_.topLeftCorner(unknowns_, unknowns_).inverse().topLeftCorner<3, 3>();
  }

 private:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 5, 5>;  // no heap
  Eigen::Matrix<double, 5, 5> matrix_ = Eigen::Matrix<double, 5, 5>::Zero();
  Row right_ = Row::Zero();
  int unknowns_, used_ = 0;
};

// So many points place a cone well enough to measure edges around it, and so near a step has done enough.
constexpr std::size_t points_for_a_start = 64;
constexpr double settled_start_px = 0.5, settled_weights_px = 0.05;

}  // namespace

Eigen::Vector3d TangentCone::center(double radius_m) const { return axis * (radius_m / std::sin(alpha_rad)); }

std::optional<TangentCone> TangentCone::of_sphere(const Eigen::Vector3d& p_C, double radius_m) {
  const double distance = p_C.norm();
  if (!(radius_m > 0) || !(distance > radius_m) || !std::isfinite(distance)) return std::nullopt;
  return TangentCone{p_C / distance, std::asin(radius_m / distance)};
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double angle_outside(const TangentCone& cone, const Eigen::Vector3d& ray) {
  return angle_between(cone.axis, ray) - cone.alpha_rad;
}

double angle_outside(const ConeFit& fit, const Eigen::Vector3d& ray) {
  const Row row = jacobian_row(perpendicular_basis(fit.cone.axis), ray);
  return angle_outside(fit.cone, ray) + row.tail<2>().dot(fit.oval_rad);
}

TangentCone moved(const TangentCone& cone, const Eigen::Vector3d& step_rad) {
  return {(cone.axis + perpendicular_basis(cone.axis) * step_rad.head<2>()).normalized(),
          cone.alpha_rad + step_rad.z()};
}

// Neighbouring arc segments err alike where texture, a shadow or the light's edge runs along the outline: as
// if there were fewer of them. The sum of a first-order autoregressive process has (1 + rho) / (1 - rho)
// times the variance of independent terms; rho is the residuals' own correlation with their neighbours.
double correlation_factor(const ConeFit& fit, const std::vector<EdgePoint>& edges) {
  constexpr double largest = 0.8;
  double least_gap_rad = 10;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const double gap = edges[i].angle_rad - edges[i - 1].angle_rad;
    if (gap > 0) least_gap_rad = std::min(least_gap_rad, gap);
  }
  double squares = 0, products = 0, previous = 0;
  int used = 0, pairs = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const EdgePoint& edge = edges[i];
    const double residual = std::sqrt(edge.weight) * angle_outside(fit, edge.ray) * edge.px_per_rad;
    const bool beside = i > 0 && edge.angle_rad - edges[i - 1].angle_rad < 1.5 * least_gap_rad;
    if (beside && edge.weight > 0 && edges[i - 1].weight > 0) {
      products += previous * residual;
      ++pairs;
    }
    used += edge.weight > 0 ? 1 : 0;
    squares += residual * residual;
    previous = residual;
  }
  if (pairs < 8 || !(squares > 0)) return 1;
  // Of independent residuals the three fitted unknowns make neighbours look contrary by so much.
  const double rho = (products / pairs) / (squares / used) + 3.0 / used;
  const double kept = std::clamp(rho, 0.0, largest);
  return (1 + kept) / (1 - kept);
}

std::optional<ConeFit> one_gauss_newton_step(const TangentCone& start, const std::vector<EdgePoint>& edges,
                                             double oval_fraction, const KnownAngle& known) {
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(start.axis);
  NormalEquations normal(oval_fraction * start.alpha_rad, known, start.alpha_rad, Row::Zero());
  double px_per_rad = 0;
  for (const EdgePoint& edge : edges) {
    const double scale = edge.px_per_rad / edge.sigma_px;
    normal.add(jacobian_row(basis, edge.ray), angle_outside(start, edge.ray), edge.weight * scale * scale);
    px_per_rad = std::max(px_per_rad, edge.weight > 0 ? edge.px_per_rad : 0);
  }
  const auto step = normal.solve();
  if (!step) return std::nullopt;

  ConeFit fit;
  fit.cone = moved(start, step->head<3>());
  fit.oval_rad = step->tail<2>();
  if (!(fit.cone.alpha_rad > 0) || !(fit.cone.alpha_rad < 1.5707)) return std::nullopt;
  fit.step_px = (step->head<2>().norm() + std::abs(step->z())) * px_per_rad;
  double chi2 = 0, squares_px2 = 0, weights = 0;
  for (const EdgePoint& edge : edges) {
    if (!(edge.weight > 0)) continue;
    const double residual_px = angle_outside(fit, edge.ray) * edge.px_per_rad;
    chi2 += edge.weight * std::pow(residual_px / edge.sigma_px, 2);
    squares_px2 += edge.weight * residual_px * residual_px;
    weights += edge.weight;
  }
  fit.residual_px = std::sqrt(squares_px2 / weights);
  const double chi2_per_dof = chi2 / std::max(1.0, weights - 3);
  fit.covariance_rad2 = normal.covariance() * std::max(1.0, chi2_per_dof) * correlation_factor(fit, edges);
  const double radius_px = std::sin(fit.cone.alpha_rad) * px_per_rad;
  fit.covariance_rad2.diagonal().array() += std::pow(common_error_px2 / radius_px / px_per_rad, 2);
  return fit;
}

std::optional<Eigen::Vector3d> RobustWeights::set(const TangentCone& start, std::vector<EdgePoint>& edges,
                                                  double floor_px, double oval_fraction, double settled_px,
                                                  const KnownAngle& known) {
  if (edges.empty()) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> basis = perpendicular_basis(start.axis);
  // The problem is linear to second order in the step, so the weights settle on one linearisation.
  points_.clear();
  for (const EdgePoint& edge : edges) {
    const double outside_px = angle_outside(start, edge.ray) * edge.px_per_rad;
    points_.push_back({jacobian_row(basis, edge.ray), outside_px, outside_px, edge.px_per_rad,
                       edge.px_per_rad / std::max(edge.sigma_px, 0.25 * floor_px)});
  }
  const auto scale_px = [&] {
    magnitudes_.clear();
    for (const Point& point : points_) magnitudes_.push_back(std::abs(point.residual_px));
    return std::max(floor_px, sigma_of_median * upper_median(magnitudes_));
  };
  // Least absolute deviations first, in sigmas: an occluder's edge must not set the scale, nor a shadow's
  // sharp one outweigh the ball's.
  Row step = Row::Zero();
  for (const bool absolute : {true, false}) {
    for (int i = 0; i < reweightings; ++i) {
      const double scale = scale_px();
      NormalEquations normal(oval_fraction * start.alpha_rad, known, start.alpha_rad, step);
      for (std::size_t k = 0; k < points_.size(); ++k) {
        const Point& point = points_[k];
        const double r = std::abs(point.residual_px);
        const double u = r / (tukey * scale);
        edges[k].weight = u < 1 ? (1 - u * u) * (1 - u * u) : 0;
        const double weight = absolute ? point.px_per_rad * point.inverse / std::max(r, floor_px)
                                       : edges[k].weight * point.inverse * point.inverse;
        normal.add(point.row, point.residual_px / point.px_per_rad, weight);
      }
      const auto change = normal.solve();
      if (!change) return std::nullopt;
      step += *change;
      for (Point& point : points_)
        point.residual_px = point.outside_px + point.row.dot(step) * point.px_per_rad;
      if (change->cwiseAbs().maxCoeff() * points_.front().px_per_rad < settled_px) break;
    }
  }
  return step.head<3>();
}

Eigen::Matrix3d center_covariance(const ConeFit& fit, double radius_m, double radius_sigma_m) {
  const Eigen::Vector3d center = fit.cone.center(radius_m);
  const double distance = center.norm();
  Eigen::Matrix3d jacobian;  // of the centre by (turn 1, turn 2, alpha)
  jacobian.leftCols<2>() = perpendicular_basis(fit.cone.axis) * distance;
  jacobian.col(2) = -center / std::tan(fit.cone.alpha_rad);
  const Eigen::Vector3d by_radius = center / radius_m * radius_sigma_m;
  return jacobian * fit.covariance_rad2 * jacobian.transpose() + by_radius * by_radius.transpose();
}

Eigen::Vector3d ray_of(const BoundaryPoint& point, double focal_px) {
  return Eigen::Vector3d(static_cast<double>(point.position_px.x()),
                         static_cast<double>(point.position_px.y()), focal_px)
      .normalized();
}

double outline_tolerance_px(double radius_px) { return 0.5 + 0.025 * radius_px; }

TangentCone BoundaryCone::rough(const TangentCone& voted, const std::vector<BoundaryPoint>& points,
                                double focal_px) {
  TangentCone cone = voted;
  for (int i = 0; i < 2; ++i) {
    const double band_rad = 0.15 * cone.alpha_rad + 1 / focal_px;
    const double cosine_inner = std::cos(std::max(0.0, cone.alpha_rad - band_rad)),
                 cosine_outer = std::cos(cone.alpha_rad + band_rad);
    rays_.clear();
    for (const BoundaryPoint& p : points) {
      const Eigen::Vector3d ray = ray_of(p, focal_px);
      const double cosine = cone.axis.dot(ray);
      if (cosine <= cosine_inner && cosine >= cosine_outer) rays_.push_back(ray);
    }
    const auto center = sphere_from_rays(rays_, 1);
    const auto found = center ? TangentCone::of_sphere(*center, 1) : std::nullopt;
    if (!found || !(std::abs(found->alpha_rad / voted.alpha_rad - 1) < 0.3)) return voted;
    cone = *found;
  }
  return cone;
}

std::optional<TangentCone> BoundaryCone::robust(const TangentCone& start,
                                                const std::vector<BoundaryPoint>& points, double focal_px,
                                                double oval_fraction) {
  TangentCone cone = start;
  for (int i = 0; i < 2; ++i) {
    const double band_rad = 0.15 * cone.alpha_rad + 1 / focal_px;
    edges_.clear();
    for (std::size_t k = 0; k < points.size(); k += 1 + points.size() / points_for_a_start) {
      EdgePoint edge;
      edge.ray = ray_of(points[k], focal_px);
      if (std::abs(angle_outside(cone, edge.ray)) > band_rad) continue;
      edge.px_per_rad = focal_px;
      edge.sigma_px = 0.5;
      edges_.push_back(edge);
    }
    const auto step_rad = weights_.set(cone, edges_, 0.3, oval_fraction, settled_weights_px);
    if (!step_rad) return std::nullopt;
    cone = moved(cone, *step_rad);
    if (!(cone.alpha_rad > 0) || !(cone.alpha_rad < M_PI / 2)) return std::nullopt;
    if (step_rad->lpNorm<1>() * focal_px < settled_start_px) break;
  }
  return cone;
}

}  // namespace ballservo
