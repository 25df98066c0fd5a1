// What the fits minimise, as their formulas say it.
#pragma once

#include <vector>

#include "perception/outline/cone_fit.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

// E(c) = sum |grad I|^2 C^2 (paper, "Raffinement").
inline double circle_cost(const UndistortedCircle& circle, const std::vector<RingPixel>& ring) {
  double cost = 0;
  for (const RingPixel& pixel : ring) {
    const double distance = (pixel.position_px - circle.center_px).norm() - circle.radius_px;
    cost += pixel.weight * distance * distance;
  }
  return cost;
}

// sum weight (angle_outside px_per_rad / sigma)^2.
inline double cone_cost(const TangentCone& cone, const std::vector<EdgePoint>& edges) {
  double cost = 0;
  for (const EdgePoint& edge : edges) {
    const double residual = angle_outside(cone, edge.ray) * edge.px_per_rad / edge.sigma_px;
    cost += edge.weight * residual * residual;
  }
  return cost;
}

}  // namespace ballservo
