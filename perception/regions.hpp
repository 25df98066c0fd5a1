// Stage 3: connected components of the class picture and how they neighbour each other (paper,
// "Segmentation").
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/color/color_table.hpp"

namespace ballservo {

/// One connected component; the background (no class) makes regions too.
struct Region {
  ClassIndex color_class = no_class;
  int pixels = 0;  ///< with what it has absorbed
  cv::Rect box;
  bool touches_border = false;
  int absorbed_by = -1;        ///< the region that encloses it and took it in (a highlight in a ball), or -1
  std::vector<int> neighbors;  ///< regions that share an edge with it, ascending
};

/// A pixel of a region with a neighbour outside it.
struct BoundaryPixel {
  int u_px = 0, v_px = 0;
  Eigen::Vector2f outward{0,
                          0};  ///< unit vector from the pixel towards what lies outside (four-neighbourhood)
};

/// All components of a class picture. Buffers are reused between frames.
class RegionMap {
 public:
  /// Finds the components (8-connected within a class, 4-connected in the background), their neighbours, and
  /// absorbs every region that is enclosed by a single region of a class and smaller than it.
  void update(const cv::Mat& classes);

  const std::vector<Region>& regions() const { return regions_; }
  /// The region that a pixel belongs to after absorption.
  int region_at(int u_px, int v_px) const { return root_[static_cast<std::size_t>(labels_(v_px, u_px))]; }

  /// The outline of a region: its pixels with a four-neighbour of another region, without those at the
  /// picture's border, which cuts but does not bound. In raster order.
  void boundary(int region, std::vector<BoundaryPixel>& boundary) const;

 private:
  struct Run {
    int begin, end, component;
    ClassIndex color_class;
  };
  int find(int component);

  cv::Mat1i labels_;         // component numbers
  std::vector<int> parent_;  // union-find over provisional components
  std::vector<int> root_;    // component -> region after absorption
  std::vector<Run> runs_;
  std::vector<std::pair<int, int>> touching_;
  std::vector<Region> regions_;
};

/// The unit normal of a class's outline at one of its boundary pixels, outwards: away from the middle of its
/// pixels in a 7x7 window, good to about 5 degrees on a straight outline; (0, 0) where they lie all around.
Eigen::Vector2f outward_normal(const cv::Mat& classes, const BoundaryPixel& pixel);

}  // namespace ballservo
