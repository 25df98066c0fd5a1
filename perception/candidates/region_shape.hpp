// What a region's whole outline is, whatever circles fit into parts of it: a disc seen aslant, or a box.
//
// The outline of a ball that something hides has corners, where the hiding edge crosses it. A round disc that
// is turned away has none: one ellipse explains all of its outline, and no sphere makes that ellipse. Nor
// does what is left of a ball fill the rectangle around it.
#pragma once

#include <limits>
#include <vector>

#include "calibration/circles/circle_vote.hpp"
#include "perception/segmentation/regions.hpp"

namespace ballservo {

/// Neutral where the outline is too short to tell.
struct RegionShape {
  /// Of the ellipse nearest to the outline, seen from straight before it: short axis by long axis, 1 for a
  /// ball wherever it stands.
  double axis_ratio = 1;
  /// RMS distance of the outline from that ellipse; infinite where there is none.
  double ellipse_residual_px = std::numeric_limits<double>::infinity();
  double box_fill = 0;  ///< of the smallest rectangle around the region: pi/4 for a disc, 1 for a box
};

/// The region's whole outline, thinned out or not, in the picture's own px (`outline`), where `pixels` were
/// counted, and undistorted (`points`), where a ball's is a conic.
RegionShape region_shape(const std::vector<BoundaryPixel>& outline, const std::vector<BoundaryPoint>& points,
                         int pixels, double focal_px);

/// Is it surely another thing than a ball, whole or partly hidden? Of an ellipse its axes tell, of any other
/// shape how it fills its rectangle.
bool is_no_balls(const RegionShape& shape);

}  // namespace ballservo
