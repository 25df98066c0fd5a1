// Round or not: what the run of the measured edge says of a supposed ball's outline.
//
// A circle of the right size fits into every box, and the box's sides lie on it in four places. What tells
// the two apart is the rest of the outline: the box's edge leaves the circle where a ball's stays on it, and
// it leaves it as a straight line does.
#pragma once

#include <cstdint>

#include "perception/outline/edge_points.hpp"

namespace ballservo {

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
};

/// Whether an edge at that offset lies on the outline, as a ball's does.
bool is_on_outline(float offset_px, double radius_px, double blur_px);

/// `offsets` and `colors` are of the same sectors. `blur_px`: the more an edge is blurred (by motion, say),
/// the further it may lie from the outline, and the less its curvature means.
OutlineShape outline_shape(const EdgeOffsets& offsets, const SectorColors& colors, double radius_px,
                           double blur_px);

}  // namespace ballservo
