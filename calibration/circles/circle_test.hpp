// The question that colour calibration asks of the on-line circle estimator, which the caller hands in: is
// this round?
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <vector>

namespace ballservo {

/// What the circle estimator found in a region.
struct RegionCircle {
  Eigen::Vector2d center_px{0, 0};
  double radius_px = 0;
  double inlier_fraction = 0;  ///< fraction of the boundary within a pixel and a half of the circle (0 to 1)
};

/// The best circle through the boundary pixels of a region, or nothing. Deterministic.
using CircleEstimator =
    std::function<std::optional<RegionCircle>(const std::vector<Eigen::Vector2f>& boundary_px)>;

}  // namespace ballservo
