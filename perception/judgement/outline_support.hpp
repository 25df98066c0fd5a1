// Is it a ball? How much of the outline has an edge on it, and how the ball's colour fills it.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/judgement/outline_shape.hpp"
#include "perception/outline/boundary_cone.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

/// Fractions from 0 to 1.
struct OutlineSupport {
  double arc = 0;          ///< of the outline: an edge lies on it, with the colour on its inner side
  double arc_in_runs = 0;  ///< the same, where such edges stand side by side (see fraction_in_arcs)
  double fill =
      0;  ///< of the disc (its part in the picture): of the ball's colour, or absorbed by its region
  double leak = 0;     ///< of a rim around the disc: of the ball's colour, as where a bar runs on
  double hidden = 0;   ///< of the outline: outside the picture, or another colour lies just inside it
  OutlineShape shape;  ///< how the measured edge follows the outline

  /// 1 for a whole ball of one colour before another background.
  double quality() const;
};

/// Which sectors of the outline (of equal angle, counted as EdgePoint::angle_rad) have something on them.
struct OutlineSectors {
  std::array<bool, most_outline_sectors> seen{};
  int count = 0;

  void see(double angle_rad);  ///< 0 to 2 pi
  double fraction() const;
  /// The fraction in arcs of at least a sixth of the turn, in which single sectors may be missing: a
  /// polygon touches its inscribed circle in many short ones.
  double fraction_in_arcs() const;
};

/// The sectors on which a boundary point lies: 48, or as many as the outline has pixels.
OutlineSectors boundary_sectors(const std::vector<BoundaryPoint>& points, const TangentCone& cone,
                                double focal_px);

/// The sectors in which an edge lies within `tolerance_px` of the fitted outline.
OutlineSectors edge_sectors(const EdgeOffsets& offsets, double tolerance_px);

/// Sees in `sectors` those with the ball's colour outside the cone's outline where the picture's colours step
/// near it, by whole pixels and no model of the edge.
void see_steps_in_own_color(const cv::Mat& bgr, const ColoredPixels& colored, const Camera& camera,
                            const TangentCone& cone, OutlineSectors& sectors);

/// How the sectors with an edge and the colour inside and around the cone speak for a ball. The edges'
/// offsets are of the same sectors, or of none where no edge was measured.
OutlineSupport outline_support(const OutlineSectors& edges, const EdgeOffsets& offsets, double blur_px,
                               const ColoredPixels& colored, const Camera& camera, const TangentCone& cone);

}  // namespace ballservo
