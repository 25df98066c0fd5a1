// A region's outline: where circles are sought.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <opencv2/core/types.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/segmentation/bit_picture.hpp"
#include "perception/segmentation/regions.hpp"

namespace ballservo {

/// Orders boundaries; keeps its buffers between calls.
class BoundaryChain {
 public:
  /// Reorders `boundary`, pixels of a picture of `size` that do not lie on its border, each once: neighbours
  /// follow each other along an outline, from its first pixel in raster order on, and one outline comes after
  /// the other.
  void order(std::vector<BoundaryPixel>& boundary, cv::Size size);

 private:
  BitPicture waiting_;  // no bit set between calls
  std::vector<BoundaryPixel> ordered_;
};

// The straight sides of a region's outline. No ball has any, but the circles that fit into a box or between
// two things do: what lies on a straight side need not be asked for circles.

/// Finds straight sides; keeps its buffers between calls.
class StraightSides {
 public:
  /// Whether each point lies on a straight side. `points` follow each other along the outlines (see
  /// BoundaryChain), where undistorted lines are straight. A side is so long that an arc of a circle as large
  /// as the whole outline would bend by more than the points scatter: of a smaller one the more.
  const std::vector<char>& find(const std::vector<BoundaryPoint>& points);

 private:
  // Of all points before one: their number is its index.
  struct Sums {
    Eigen::Vector2d place{0, 0};
    Eigen::Matrix2d square = Eigen::Matrix2d::Zero();  // place * place'
  };
  bool is_straight(std::size_t begin, std::size_t end) const;

  std::vector<Sums> sums_;
  std::vector<double> path_px_;  // along the outline to each point
  std::vector<char> straight_;
};

// What a region's whole outline is, whatever circles fit into parts of it: a disc seen aslant, or a box.
//
// The outline of a ball that something hides has corners, where the hiding edge crosses it. A round disc that
// is turned away has none: one ellipse explains all of its outline, and no sphere makes that ellipse. Nor
// does what is left of a ball fill the rectangle around it.

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

struct RegionOutline {
  std::vector<BoundaryPoint> points;  ///< undistorted, between the region's last pixel and what is beyond
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
