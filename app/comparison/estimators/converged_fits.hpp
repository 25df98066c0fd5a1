// The fits of perception, converged: the very same residuals on the very same points and weights, handed to
// Ceres with automatic differentiation. Off line only: they tell what exactly one Gauss-Newton step leaves
// behind.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "perception/outline/cone_fit.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// rho of sum_i w_i s^2 rho((r_i / s)^2), r_i the distance of a point from the outline (px), s `scale_px`:
/// least squares, Huber's (1964), Cauchy's, or Tukey's biweight (Beaton and Tukey 1974).
enum class RobustLossKind { squares, huber, cauchy, tukey };
std::string_view robust_loss_name(RobustLossKind kind);  ///< "cauchy"

struct RobustLoss {
  RobustLossKind kind = RobustLossKind::squares;
  double scale_px = 0.3;
};

/// What Ceres did.
struct Convergence {
  double start_cost = 0;  ///< at the start, see circle_cost and cone_cost
  double cost = 0;        ///< where it ended
  int iterations = 0;     ///< steps taken, rejected ones included, from the start that won
  int starts = 1;         ///< tried; the lowest cost won
  /// By Ceres' own criteria, and the residuals are perpendicular to every column of the Jacobian to 1e-6
  /// (cosine; with a robust loss 1e-4).
  bool converged = false;
  double condition = 0;  ///< of the weighted Jacobian at the end: largest over smallest singular value
  /// Weighted RMS distance of the points from the outline, as perception's fits state it.
  double residual_px = 0;
};

/// A fit's weighted residuals, sqrt(w) r, and their derivatives by its three unknowns, as Ceres has them.
struct Linearisation {
  Eigen::VectorXd residuals;
  Eigen::Matrix<double, Eigen::Dynamic, 3> jacobian;

  double condition() const;  ///< largest over smallest singular value of the Jacobian; infinite if singular
};

/// The paper's E(c) = sum |grad I|^2 C^2, C = sqrt((p_x - c_x)^2 + (p_y - c_y)^2) - c_r (paper,
/// "Raffinement").
double circle_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring);

/// Of that cost, by (c_x, c_y, c_r).
Linearisation linearise_circle(const UndistortedCircle& circle, const std::vector<RingPixel>& ring);

struct ConvergedCircle {
  UndistortedCircle circle;
  Convergence convergence;
};

/// The minimum of circle_cost, or of its robust twin, near `start` with the pixels held fixed. A robust cost
/// has several minima: it is also sought from the least-squares one. Nothing for fewer than 3 pixels of
/// weight, for values that are not finite, or where the minimum is no circle.
std::optional<ConvergedCircle> converge_circle(const UndistortedCircle& start,
                                               const std::vector<RingPixel>& ring,
                                               const RobustLoss& loss = {});

/// sum weight (angle_outside px_per_rad / sigma)^2: the cost of perception's cone fit, zero for rays that all
/// touch the ball, u.C = sqrt(|C|^2 - R^2).
double cone_cost(const TangentCone& cone, const std::vector<EdgePoint>& edges);

/// Of that cost, by (turn, turn, change of alpha) as `moved` takes them.
Linearisation linearise_cone(const TangentCone& cone, const std::vector<EdgePoint>& edges);

struct ConvergedCone {
  TangentCone cone;
  Convergence convergence;
};

/// The minimum of cone_cost near `start` with points and weights held fixed. Nothing as for converge_circle.
/// With a robust loss the points' own robust weights count as 1: the loss stands in for them.
std::optional<ConvergedCone> converge_cone(const TangentCone& start, const std::vector<EdgePoint>& edges,
                                           const RobustLoss& loss = {});

}  // namespace ballservo
