// Is it a ball? What the region's boundary, the measured edges, the colour and the shading say together.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/detector_options.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/outline/ball_fitter.hpp"
#include "perception/outline/ball_observation.hpp"

namespace ballservo {

/// Judges the candidates of one class in one picture. What it is made from must outlive it.
class BallJudge {
 public:
  /// `min_quality` is what suffices for a ball here.
  BallJudge(const cv::Mat& bgr, const ColoredPixels& colored, const RayTable& rays, const BallFitter& fitter,
            const DetectorOptions& options, double min_quality)
      : bgr_(bgr),
        colored_(colored),
        rays_(rays),
        fitter_(fitter),
        options_(options),
        min_quality_(min_quality) {}

  /// What the boundary points say before any edge was measured, and a quick look at the picture where there
  /// are none: as if every edge that may be there lay on the outline.
  OutlineSupport early_support(const std::vector<BoundaryPoint>& boundary, const TangentCone& cone) const;
  /// Why that is no ball, with room for what the edges may add; null where it may be one.
  const char* early_rejection(const OutlineSupport& support) const;

  /// Why the ball that `fitter` has just fitted is none; null where outline and colour together show one.
  /// Sets its support and quality.
  const char* rejection(const std::vector<BoundaryPoint>& boundary, BallObservation& ball) const;

  // Of the ball last fitted and rejected:
  /// Is the region enclosed by its outline, well inside it all around? So it is in dim light or much
  /// compressed pictures, where the colour says little of the rim; but the edge runs around all of it.
  bool encloses(const std::vector<BoundaryPoint>& region, const BallObservation& ball) const;
  /// Does it suffice where a ball is expected?
  bool suffices_where_expected(const BallObservation& ball) const;
  /// On how much of the outline that runs in the picture an edge lies.
  double share_on_outline(const BallObservation& ball) const;

 private:
  const char* rejection_by_support(const BallObservation& ball) const;
  bool shows_a_sphere(const BallObservation& ball) const;

  const cv::Mat& bgr_;
  const ColoredPixels& colored_;
  const RayTable& rays_;
  const BallFitter& fitter_;
  const DetectorOptions& options_;
  double min_quality_;
};

}  // namespace ballservo
