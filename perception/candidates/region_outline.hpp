// A region's outline: where circles are sought.
#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/candidates/straight_sides.hpp"
#include "perception/segmentation/boundary_chain.hpp"
#include "perception/segmentation/regions.hpp"

namespace ballservo {

struct RegionOutline {
  std::vector<BoundaryPoint>
      points;  ///< undistorted, between the region's last pixel and the first beyond it
  std::vector<BoundaryPixel> pixels;  ///< of the picture, one for each point

  void clear() { resize(0); }
  void resize(std::size_t count) {
    points.resize(count);
    pixels.resize(count);
  }
};

/// Traces outlines; keeps its buffers between calls.
class OutlineTracer {
 public:
  /// The boundary of a region in a window of the picture, without straight sides; of a long one only so many
  /// points as tell where its circles are; none of one that as a whole is no ball's. Valid until the next
  /// call.
  const RegionOutline& trace(const RegionMap& regions, int region, const cv::Point& window,
                             const RayTable& rays);

 private:
  BoundaryChain chain_;
  StraightSides sides_;
  std::vector<BoundaryPixel> boundary_;
  RegionOutline outline_;
};

}  // namespace ballservo
