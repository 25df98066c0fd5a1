// A quadratic programme in two variables, solved exactly: the command nearest to the wanted one that keeps
// its distance.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

namespace ballservo {

/// a . u <= b.
struct LinearBound {
  Eigen::Vector2d a{0, 0};
  double b = 0;
};

/// minimise  (u - wanted)^T diag(weight) (u - wanted) + slack_weight * max(0, soft.a . u - soft.b)^2
/// subject to bounds[k].a . u <= bounds[k].b
struct BarrierProblem {
  static constexpr std::size_t max_bounds = 24;
  Eigen::Vector2d wanted{0, 0}, weight{1, 1};
  std::array<LinearBound, max_bounds> bounds;
  std::size_t count = 0;
  std::optional<LinearBound> soft;
  double slack_weight = 0;

  /// More than fit are dropped: the shield has the last word.
  void add(const LinearBound& bound) {
    if (count < max_bounds) bounds[count++] = bound;
  }
};

/// The minimiser, by enumeration of the active sets: none, each one, each pair (Nocedal and Wright,
/// "Numerical Optimization", 16.1), once with the soft bound kept and once with it left. Nothing where no
/// point keeps all bounds, or an input is not finite. Allocates nothing.
std::optional<Eigen::Vector2d> solve(const BarrierProblem& problem);

}  // namespace ballservo
