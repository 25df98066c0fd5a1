// What a region's boundary tells of a ball's cone, before any edge is measured.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calibration/circles/circle_vote.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

/// The unit ray (camera frame) of an undistorted place.
Eigen::Vector3d ray_of(const BoundaryPoint& point, double focal_px);

/// How far (px) an edge or a boundary pixel may lie from a ball's outline and still speak for it.
double outline_tolerance_px(double radius_px);

/// Cones through boundary points; keeps its buffers between calls.
class BoundaryCone {
 public:
  /// Through the points near the voted cone: enough to ask whether a ball is likely. The voted one itself
  /// where they say nothing.
  TangentCone rough(const TangentCone& voted, const std::vector<BoundaryPoint>& points, double focal_px);

  /// The votes look for a circle; a ball off the axis is none, and they may settle on a part of it. The cone
  /// through the points near the rough one is the whole ball's. Nothing for a degenerate set.
  std::optional<TangentCone> robust(const TangentCone& rough, const std::vector<BoundaryPoint>& points,
                                    double focal_px, double oval_fraction);

 private:
  std::vector<Eigen::Vector3d> rays_;
  std::vector<EdgePoint> edges_;
  RobustWeights weights_;
};

}  // namespace ballservo
