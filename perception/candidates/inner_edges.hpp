// Edges inside a region: where a ball stands before a thing of its own colour, most of its outline is no
// region's boundary, but shade and shadow still draw it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

/// A place (undistorted, px) where the picture changes most across, and the unit direction across.
struct InnerEdge {
  Eigen::Vector2f position_px{0, 0};
  Eigen::Vector2f across{0, 0};  ///< its sign means nothing
};

/// Finds them along rows and columns; keeps its buffers between calls.
class InnerEdges {
 public:
  InnerEdges();

  /// The edges in a box (picture px) of the picture, between pixels that have the colour on all sides.
  /// `region_pixels`: how many of the box's may be looked at. In no order of space.
  void find(const cv::Mat& bgr, const ColoredPixels& colored, const RayTable& rays, const cv::Rect& box,
            int region_pixels, std::vector<InnerEdge>& edges);

 private:
  struct Peak {
    int u_px, v_px, step;
  };
  void look_along(const cv::Mat& bgr, const ColoredPixels& colored, cv::Point first, cv::Point along,
                  int length);
  void keep_strong();

  std::vector<int> steps_;  // along a line
  std::array<int, 256> histogram_{};
  std::vector<Peak> peaks_;
};

}  // namespace ballservo
