// Is there an edge all along a supposed outline? A quick look, whole pixels and no model of the edge: for
// proposals that most often are wrong.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

struct OutlineScoutOptions {
  double reach_px = 5;       ///< how far from the supposed outline the edge may lie, at most its radius
  double min_support = 0.6;  ///< of the sectors must have such a step on the outline
};

/// An outline with an edge on it.
struct ScoutedOutline {
  TangentCone cone;                   ///< moved onto the edge
  std::vector<BoundaryPoint> points;  ///< where they have it: undistorted px, no normals, in order around it
};

/// Moves the cone to the edges near its outline in the picture, coarse to fine, and says where they lie on it
/// in the end. False, and `found` of no meaning, where fewer sectors than asked for have one.
bool scout_outline(const cv::Mat& bgr, const Camera& camera, const TangentCone& start,
                   const OutlineScoutOptions& options, ScoutedOutline& found);

}  // namespace ballservo
