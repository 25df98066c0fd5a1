// Is it a ball? How much of the outline has an edge on it, and how the ball's colour fills it.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/outline/cone_fit.hpp"
#include "perception/outline/edge_points.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

// Round or not: what the run of the measured edge says of a supposed ball's outline.
//
// A circle of the right size fits into every box, and the box's sides lie on it in four places. What tells
// the two apart is the rest of the outline: the box's edge leaves the circle where a ball's stays on it, and
// it leaves it as a straight line does.

/// What the class picture shows at a sector of the outline.
enum class SectorColor : std::uint8_t {
  unseen,   ///< outside the picture
  covered,  ///< just inside there is another colour: something stands before the ball, or there is none
  bounded,  ///< the ball's colour inside, another outside
  leaking   ///< the ball's colour on both sides
};

using SectorColors = PerSector<SectorColor>;

/// Fractions from 0 to 1.
struct OutlineShape {
  /// Of the sectors where the ball's colour lies inside and an edge or the colour's end contradicts or
  /// confirms the outline: those that confirm it.
  double match = 1;
  /// Of the sectors where the edge's curvature can be told: those where it is straight.
  double straight = 0;
  double roundness() const { return match * (1 - straight); }
};

/// Whether an edge at that offset lies on the outline, as a ball's does.
bool is_on_outline(float offset_px, double radius_px, double blur_px);

/// `offsets` and `colors` are of the same sectors. `blur_px`: the more an edge is blurred (by motion, say),
/// the further it may lie from the outline, and the less its curvature means.
OutlineShape outline_shape(const EdgeOffsets& offsets, const SectorColors& colors, double radius_px,
                           double blur_px);

/// Fractions from 0 to 1.
struct OutlineSupport {
  double arc = 0;          ///< of the outline: an edge lies on it, with the colour on its inner side
  double arc_in_runs = 0;  ///< the same, where such edges stand side by side (see fraction_in_arcs)
  double fill = 0;         ///< of the disc in the picture: of the ball's colour, or absorbed by its region
  double leak = 0;         ///< of a rim around the disc: of the ball's colour, as where a bar runs on
  double hidden = 0;       ///< of the outline: outside the picture, or another colour lies just inside it
  OutlineShape shape;      ///< how the measured edge follows the outline

  /// 1 for a whole ball of one colour before another background.
  double quality() const;
};

/// Which sectors of the outline (of equal angle, counted as EdgePoint::angle_rad) have something on them.
struct OutlineSectors : PerSector<bool> {
  using PerSector::PerSector;
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
