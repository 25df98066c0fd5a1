// Is it a ball? How much of the outline has an edge on it, and how the ball's colour fills it.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/edge_points.hpp"
#include "perception/regions.hpp"

namespace ballservo {

/// Fractions from 0 to 1.
struct OutlineSupport {
  double arc = 0;  ///< of the outline: an edge lies on it
  double fill =
      0;  ///< of the disc (its part in the picture): of the ball's colour, or absorbed by its region
  double leak = 0;  ///< of a rim around the disc: of the ball's colour, as where a bar runs on

  /// 1 for a whole ball of one colour before another background.
  double quality() const;
};

/// Which sectors of the outline (of equal angle, counted as EdgePoint::angle_rad) have something on them.
using OutlineSectors = std::vector<bool>;

/// The sectors in which an edge lies within `tolerance_px` of the fitted outline; as many as there are
/// stretches.
OutlineSectors edge_sectors(const OutlineEdges& edges, const ConeFit& fit, double tolerance_px);

/// How the sectors with an edge and the colour inside and around the cone speak for a ball. `classes` is the
/// closed class picture of the window whose top-left pixel is `window`; `region` is the ball's region in
/// `regions`, which belong to the same window.
OutlineSupport outline_support(const OutlineSectors& edges, const cv::Mat& classes, cv::Point window,
                               const RegionMap& regions, int region, const RayTable& rays,
                               const TangentCone& cone, const OutlineEllipse& outline);

}  // namespace ballservo
