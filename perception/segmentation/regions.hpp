// Stage 3: connected components of the class pictures and how they neighbour each other (paper,
// "Segmentation"), from runs of equal pixels: its cost is a look at every word and grows with the runs.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "calibration/color/color_table.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

/// Pixels of one class, or of none, from u = begin to end - 1 of row v.
struct Run {
  int v, begin, end;
  ClassIndex color_class;
};

/// One connected component; the background (no class) makes regions too.
struct Region {
  ClassIndex color_class = no_class;
  int pixels = 0;  ///< with what it has absorbed
  cv::Rect box;
  bool touches_border = false;
  static constexpr int no_neighbor = -1, several = -2;
  int only_neighbor = no_neighbor;  ///< the region that shares an edge with it, or one of these
  int absorbed_by = -1;  ///< the region that encloses it and took it in (a highlight in a ball), or -1
};

/// A pixel of a region with a neighbour outside it.
struct BoundaryPixel {
  int u_px = 0, v_px = 0;
  Eigen::Vector2f outward{0, 0};  ///< unit normal there (see outward_normal); (0, 0): not known
};

/// All components of the class pictures. Takes memory at first and for larger pictures alone.
class RegionMap {
 public:
  /// Of a picture of more runs (but one a row in any case) those of a class that are shorter than 2 pixels
  /// become background; if that does not suffice, shorter than 4, 8 and so on: noise, a fine pattern of its
  /// colour.
  explicit RegionMap(int max_runs = 1 << 16) : max_runs_(max_runs) {}

  /// Finds the components (8-connected within a class, 4-connected in the background), their neighbours, and
  /// absorbs every region that is enclosed by a single region of a class and smaller than it: its pixels
  /// become that class's too. `classes` are pictures of `size`.
  void update(const ClassPictures& classes, cv::Size size);

  /// Each class's pixels, with those that it absorbed and without runs that were too many.
  const ClassPictures& classes() const { return classes_; }
  const BitPicture& pixels_of(ClassIndex color_class) const {
    return classes_[static_cast<std::size_t>(color_class) - 1];
  }

  /// In raster order of their first pixels.
  const std::vector<Region>& regions() const { return regions_; }
  /// Runs of a class shorter than this counted as background; 1 where the picture had not too many.
  int shortest_run_px() const { return shortest_run_px_; }

  /// The outline of a region: its pixels with a four-neighbour of another region, without those at the
  /// picture's border, which cuts but does not bound. In raster order, without normals.
  void boundary(int region, std::vector<BoundaryPixel>& boundary) const;

 private:
  bool try_to_cut(cv::Size size, int max_runs);
  void cut_runs(cv::Size size);
  void reserve(std::size_t runs);
  int component_of(int run);
  void join_runs();
  void number_components();
  void find_surroundings();
  void absorb_enclosed();
  void list_runs();

  int max_runs_, shortest_run_px_ = 1;
  std::vector<Run> runs_;       // in raster order; they cover the picture
  std::vector<int> row_begin_;  // of a row: its first run
  ClassPictures classes_;
  std::vector<Region> regions_;
  std::vector<int> parent_;     // of a run: union-find while they are joined, then the region
  std::vector<int> next_run_;   // of a run: the next one of the same region and what it absorbed, or -1
  std::vector<int> first_run_;  // of a region, with what it has absorbed
  std::vector<std::pair<int, int>> touching_;  // runs that share an edge
};

/// The regions in which balls may be: of a class, not absorbed, of at least `min_pixels`; the largest
/// `max_regions` of them, in raster order. Returns how many more there are.
int choose_regions(const std::vector<Region>& regions, double min_pixels, int max_regions,
                   std::vector<int>& chosen);

/// The unit normal of a class's outline at one of its boundary pixels, outwards: away from the middle of its
/// pixels in a 7x7 window, good to about 5 degrees on a straight outline; (0, 0) where they lie all around.
Eigen::Vector2f outward_normal(const BitPicture& colored, const BoundaryPixel& pixel);

}  // namespace ballservo
