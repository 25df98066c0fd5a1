// The fits of perception, converged: the very same residuals on the very same points and weights, handed to
// Ceres with automatic differentiation. Off line only: they tell what exactly one Gauss-Newton step leaves
// behind.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "perception/outline/cone_fit.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// rho of sum_i w_i s^2 rho((r_i / s)^2), r_i the distance of a point from the outline (px), s `scale_px`:
/// least squares, Huber's (1964), Cauchy's, or Tukey's biweight (Beaton and Tukey 1974).
enum class RobustLossKind { squares, huber, cauchy, tukey };

struct RobustLoss {
  RobustLossKind kind = RobustLossKind::squares;
  double scale_px = 0.3;
};

/// What Ceres did.
struct Convergence {
  double cost = 0;     ///< where it ended: sum of the squares of the weighted residuals
  int iterations = 0;  ///< steps taken, rejected ones included, from the start that won
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
};

/// Of a Jacobian whose normal matrix, or its inverse, this is: largest over smallest singular value; infinite
/// if singular.
double condition_of(const Eigen::Matrix3d& normal);

/// Two shapes are fitted:
/// a circle to the ring's pixels, by (c_x, c_y, c_r): the paper's E(c) = sum |grad I|^2 C^2,
///   C = sqrt((p_x - c_x)^2 + (p_y - c_y)^2) - c_r (paper, "Raffinement");
/// a cone to edge points, by (turn, turn, change of alpha) as `moved` takes them: sum weight
///   (angle_outside px_per_rad / sigma)^2, zero for rays that all touch the ball, u.C = sqrt(|C|^2 - R^2).
///   With a robust loss the points' own robust weights count as 1: the loss stands in for them.
template <class Shape>
struct Converged {
  Shape shape;
  Convergence convergence;
};

/// The minimum near `start` with the points held fixed. A robust cost has several minima: it is also sought
/// from the least-squares one. Nothing for fewer than 3 points of weight, for values that are not finite, or
/// where the minimum is no such shape.
template <class Shape, class Point>
std::optional<Converged<Shape>> converge(const Shape& start, const std::vector<Point>& points,
                                         const RobustLoss& loss = {});

template <class Shape, class Point>
Linearisation linearise(const Shape& at, const std::vector<Point>& points);

}  // namespace ballservo
