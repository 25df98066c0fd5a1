// The fits of perception, converged: the very same residuals on the very same points and weights, handed to
// Ceres with automatic differentiation. Off line only: they tell what exactly one Gauss-Newton step leaves
// behind.
#pragma once

#include <optional>
#include <vector>

#include "perception/cone_fit.hpp"
#include "perception/paper_refinement.hpp"

namespace ballservo {

/// What Ceres did.
struct Convergence {
  double start_cost = 0;  ///< at the start, see circle_cost and cone_cost
  double cost = 0;        ///< where it ended
  int iterations = 0;     ///< steps taken, rejected ones included
  bool converged = false;
  double residual_px =
      0;  ///< weighted RMS distance of the points from the outline, as perception's fits state it
};

/// The paper's E(c) = sum |grad I|^2 C^2, C = sqrt((p_x - c_x)^2 + (p_y - c_y)^2) - c_r (paper,
/// "Raffinement").
double circle_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring);

struct ConvergedCircle {
  UndistortedCircle circle;
  Convergence convergence;
};

/// The minimum of circle_cost near `start` with the pixels held fixed. Nothing for fewer than 3 pixels of
/// weight, for values that are not finite, or where the minimum is no circle.
std::optional<ConvergedCircle> converge_circle(const UndistortedCircle& start,
                                               const std::vector<RingPixel>& ring);

/// sum weight (angle_outside px_per_rad / sigma)^2: the cost of perception's cone fit, zero for rays that all
/// touch the ball, u.C = sqrt(|C|^2 - R^2).
double cone_cost(const TangentCone& cone, const std::vector<EdgePoint>& edges);

struct ConvergedCone {
  TangentCone cone;
  Convergence convergence;
};

/// The minimum of cone_cost near `start` with points and weights held fixed. Nothing as for converge_circle.
std::optional<ConvergedCone> converge_cone(const TangentCone& start, const std::vector<EdgePoint>& edges);

}  // namespace ballservo
