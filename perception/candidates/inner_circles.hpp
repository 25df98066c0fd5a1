// Circles that edges inside a region speak for, together with what the region's boundary has of them.
//
// Each edge votes for every centre on the line across it (Hough's transform with the gradient's direction);
// the circles around the fullest places are held against the picture.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/candidates/outline_scout.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

// Edges inside a region: where a ball stands before a thing of its own colour, most of its outline is no
// region's boundary, but shade and shadow still draw it.

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

struct InnerCircle {
  CircleEstimate circle;  ///< undistorted px; its votes and points are those of the fullest cells
  ScoutedOutline outline;
};

/// Keeps its buffers between calls.
class InnerCircles {
 public:
  InnerCircles();

  /// The circle in a region of the picture that has most votes for its length and an edge all along it; none
  /// where there is no such one. `boundary` are the region's boundary points, `edges` those inside it. Valid
  /// until the next call.
  const InnerCircle* find(const cv::Mat& bgr, const Camera& camera,
                          const std::vector<BoundaryPoint>& boundary, const std::vector<InnerEdge>& edges);

 private:
  struct Point {
    Eigen::Vector2f position_px{0, 0}, across{0, 0};
    bool either_way = false;  // the direction's sign means nothing; otherwise it is outwards
  };
  struct Proposal {
    Eigen::Vector2f center_px{0, 0};
    float radius_px = 0;
    int votes = 0, points = 0;
    float score = 0;
  };
  std::uint16_t* row_of(std::vector<std::uint16_t>& cells, std::ptrdiff_t v) const {
    return cells.data() + v * columns_;
  }
  bool vote();
  void vote_along(const Eigen::Vector2f& from_px, const Eigen::Vector2f& direction);
  void smooth_votes();
  void propose();
  template <class F>
  void for_each_agreeing(const Eigen::Vector2f& center_px, const F& f) const;
  void vote_radius(Proposal& proposal);
  void fit_circle(Proposal& proposal) const;
  bool is_supported(const cv::Mat& bgr, const Camera& camera, const Proposal& proposal);

  Eigen::Vector2f origin_px_{0, 0};
  float cell_px_ = 1, max_radius_px_ = 0;
  int columns_ = 0, rows_ = 0;
  std::vector<Point> points_;
  std::vector<std::uint16_t> votes_, smooth_;
  std::vector<int> radii_;
  std::vector<Proposal> proposals_;
  InnerCircle found_;
};

}  // namespace ballservo
