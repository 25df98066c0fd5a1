// The order of a region's boundary pixels: one after the other along its outlines.
#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

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

}  // namespace ballservo
