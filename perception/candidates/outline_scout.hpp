// Is there an edge all along a supposed outline? A quick look, whole pixels and no model of the edge: for
// proposals that most often are wrong.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

/// An outline with an edge on it.
struct ScoutedOutline {
  TangentCone cone;                   ///< moved onto the edge
  std::vector<BoundaryPoint> points;  ///< where they have it: undistorted px, no normals, in order around it
};

/// Moves the cone to the edges near its outline in the picture, coarse to fine, and says where they lie on it
/// in the end. `reach_px`: how far from the supposed outline they may lie, at most its radius. False, and
/// `found` of no meaning, where a smaller part of the sectors than `min_support` has one.
bool scout_outline(const cv::Mat& bgr, const Camera& camera, const TangentCone& start, double reach_px,
                   double min_support, ScoutedOutline& found);

}  // namespace ballservo
