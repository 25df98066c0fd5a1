// The stages of one picture, for those who want to see them (paper, figures 2 to 4).
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "calibration/circles/circle_vote.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/segmentation/regions.hpp"

namespace ballservo {

struct DetectionStages {
  cv::Rect window;
  cv::Mat classified, opened, closed;  ///< class numbers, CV_8UC1, of the window
  struct Candidate {
    ClassIndex color_class = no_class;
    std::vector<BoundaryPixel> outline;  ///< of the region, without what earlier circles took away (px)
    std::vector<BoundaryPixel> removed;  ///< what this circle takes away
    VoteHistogram votes;                 ///< over undistorted px, relative to the principal point
    CircleEstimate estimate;
    std::vector<Eigen::Vector2d> estimate_outline_px;  ///< the voted circle in the picture as given
    std::vector<Eigen::Vector2d> ring_px;              ///< pixels or edge points that the refinement used
    std::vector<Eigen::Vector2d> refined_outline_px;
    OutlineSupport support;
    bool accepted = false;
    const char* reason = "";  ///< why it was not accepted
  };
  std::vector<Candidate> candidates;
};

}  // namespace ballservo
