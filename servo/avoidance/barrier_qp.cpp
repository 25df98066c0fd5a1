#include "servo/avoidance/barrier_qp.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace ballservo {

namespace {

constexpr double tolerance = 1e-9;

/// The quadratic 1/2 u^T H u - g^T u under linear bounds, of which the last may be told to be left (>=).
class Enumeration {
 public:
  Enumeration(const Eigen::Matrix2d& H, const Eigen::Vector2d& g, const LinearBound* bounds,
              std::size_t count)
      : H_(H), H_inverse_(H.inverse()), g_(g), bounds_(bounds), count_(count) {}

  std::optional<Eigen::Vector2d> solve() {
    const Eigen::Vector2d free = H_inverse_ * g_;
    if (keeps_all(free)) return free;
    for (std::size_t i = 0; i < count_; ++i) {
      const LinearBound& p = bounds_[i];
      const Eigen::Vector2d q = H_inverse_ * p.a;
      const double length2 = p.a.dot(q);
      if (length2 > 1e-15) consider(free + q * ((p.b - p.a.dot(free)) / length2));
      for (std::size_t j = 0; j < i; ++j) {
        const LinearBound& r = bounds_[j];
        const double det = p.a.x() * r.a.y() - p.a.y() * r.a.x();
        if (std::abs(det) < 1e-12) continue;
        consider({(p.b * r.a.y() - p.a.y() * r.b) / det, (p.a.x() * r.b - p.b * r.a.x()) / det});
      }
    }
    if (!std::isfinite(best_)) return std::nullopt;
    return best_u_;
  }

  double cost(const Eigen::Vector2d& u) const { return 0.5 * u.dot(H_ * u) - g_.dot(u); }

 private:
  bool keeps_all(const Eigen::Vector2d& u) const {
    for (std::size_t k = 0; k < count_; ++k) {
      if (!(bounds_[k].a.dot(u) <= bounds_[k].b + tolerance)) return false;
    }
    return true;
  }
  void consider(const Eigen::Vector2d& u) {
    const double c = cost(u);
    if (!(c < best_) || !keeps_all(u)) return;
    best_ = c;
    best_u_ = u;
  }

  Eigen::Matrix2d H_, H_inverse_;
  Eigen::Vector2d g_;
  const LinearBound* bounds_;
  std::size_t count_;
  double best_ = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best_u_{0, 0};
};

}  // namespace

std::optional<Eigen::Vector2d> solve(const BarrierProblem& problem) {
  if (!problem.wanted.allFinite() || !(problem.weight.minCoeff() > 0.0)) return std::nullopt;
  std::array<LinearBound, BarrierProblem::max_bounds + 1> bounds;
  for (std::size_t k = 0; k < problem.count; ++k) {
    bounds[k] = problem.bounds[k];
    if (!bounds[k].a.allFinite() || !std::isfinite(bounds[k].b)) return std::nullopt;
  }
  Eigen::Matrix2d H = problem.weight.asDiagonal();
  Eigen::Vector2d g = problem.weight.cwiseProduct(problem.wanted);
  if (!problem.soft) return Enumeration(H, g, bounds.data(), problem.count).solve();

  const LinearBound& soft = *problem.soft;
  if (!soft.a.allFinite() || !std::isfinite(soft.b)) return std::nullopt;
  // The cost is convex: where the minimum over the side that keeps the soft bound does not touch it, it is
  // the minimum of all; else the other side holds one that is as good.
  bounds[problem.count] = soft;
  const auto kept = Enumeration(H, g, bounds.data(), problem.count + 1).solve();
  if (kept && soft.a.dot(*kept) < soft.b - tolerance) return kept;
  H += problem.slack_weight * soft.a * soft.a.transpose();
  g += problem.slack_weight * soft.b * soft.a;
  bounds[problem.count] = {-soft.a, -soft.b};
  const auto left = Enumeration(H, g, bounds.data(), problem.count + 1).solve();
  return left ? left : kept;
}

}  // namespace ballservo
