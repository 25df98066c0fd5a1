// Is it a ball? What the region's boundary, the measured edges, the colour and the shading say together.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/judgement/second_look.hpp"
#include "perception/outline/ball_fitter.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/segmentation/bit_picture.hpp"

namespace ballservo {

/// Below this radius (px) nothing is a ball: some circle fits into a few pixels of anything.
inline constexpr double min_ball_radius_px = 3;
/// What suffices for a ball that nothing else speaks for.
inline constexpr double min_ball_quality = 0.36;
/// Below, it is doubtful, and worth a second look where nothing says that a ball is there.
inline constexpr double doubtful_quality = 0.8;

/// Below this radius (px) an outline alone tells too little.
inline constexpr double small_ball_px = 12;
/// So many times more things look like balls of this radius than like balls of `small_ball_px`, as a
/// logarithm: as the room for things of one size grows, with the third power of the distance.
double log_look_alikes_by_size(double radius_px);

/// Of a ball's rim so much may have its colour.
inline constexpr double max_leak = 0.55;
/// On so much of an outline an edge must lie where a ball is expected.
inline constexpr double min_expected_edge = 0.30;

/// What is known of a region before it is looked at.
struct RegionPrior {
  double min_quality;     ///< that suffices for a ball here
  bool anywhere = false;  ///< the whole picture is searched: nothing says that a ball of the class is there
  double log_look_alikes = 0;  ///< ln of the number of regions of its class and about its size, with it
  double share = 0;            ///< of its class's pixels, in the regions that are looked at
  bool thorough = false;       ///< a second look may decide for a ball that shows too little of its outline
};

/// One class in a picture.
struct ClassView {
  const cv::Mat& bgr;
  const ColoredPixels& colored;
  const CameraResponse& response;
  RegionPrior prior;
};

struct Verdict {
  OutlineSupport support;
  double quality = 0;
  const char* reason = nullptr;  ///< why it is no ball; null where it is one
};

/// Judges the candidates of one class in one picture. What it is made from must outlive it.
class BallJudge {
 public:
  BallJudge(const ClassView& view, const RayTable& rays) : view_(view), rays_(rays) {}

  /// By the boundary points, before any edge was measured, and a quick look at the picture where there are
  /// none: as if every edge that may be there lay on the outline. With room for what the edges may add.
  Verdict early(const std::vector<BoundaryPoint>& boundary, const TangentCone& cone) const;

  /// By the edges that were measured; the paper's fit measures none, there the boundary points stand in.
  Verdict of(const OutlineFit& fit, const std::vector<BoundaryPoint>& boundary) const;

  // Of a ball that was rejected:
  /// Is the region enclosed by its outline, well inside it all around? So it is in dim light or much
  /// compressed pictures, where the colour says little of the rim; but the edge runs around all of it.
  bool encloses(const std::vector<BoundaryPoint>& region, const OutlineFit& fit,
                const OutlineSupport& support) const;
  /// Does it suffice where a ball is expected?
  bool suffices_where_expected(const OutlineFit& fit, const OutlineSupport& support) const;
  /// Log odds that it is a half-hidden one, of which a second look saw that much.
  double half_hidden_log_odds(const OutlineFit& fit, const OutlineSupport& support,
                              const SecondLook::Look& look) const;

 private:
  const char* rejection(const OutlineFit& fit, const Verdict& verdict, bool behind_something) const;
  bool shows_a_sphere(const OutlineFit& fit, const OutlineSupport& support, bool behind_something) const;

  const ClassView& view_;
  const RayTable& rays_;
};

/// On how much of the outline that runs in the picture an edge lies.
double share_on_outline(const OutlineFit& fit);

}  // namespace ballservo
