// The balls of one region: circles voted from its boundary and sought inside it, each verified.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "perception/ball_verifier.hpp"
#include "perception/candidates/inner_circles.hpp"
#include "perception/candidates/region_outline.hpp"
#include "perception/detection_stages.hpp"

namespace ballservo {

class RegionSearch {
 public:
  RegionSearch(std::shared_ptr<const RayTable> rays, const DetectorOptions& options);

  /// Adds the balls of a region, which lies in a window of the picture, to `balls`.
  void find(const cv::Mat& bgr, const RegionMap& regions, int region, const cv::Point& window,
            const CameraResponse& response, const RegionPrior& prior, std::vector<BallObservation>& balls,
            DetectionStages* stages);

  BallVerifier& verifier() { return verifier_; }

 private:
  void find_by_votes(const ClassView& view, const RegionOutline& outline, RandomEngine& engine,
                     std::vector<BallObservation>& balls, DetectionStages* stages);
  void find_inside(const ClassView& view, const RegionOutline& outline, const Region& region,
                   std::size_t first_known, std::vector<BallObservation>& balls, DetectionStages* stages);
  void show(ClassIndex color_class, const VotedCircle& circle, const VerifiedCandidate& candidate,
            DetectionStages* stages) const;

  std::shared_ptr<const RayTable> rays_;
  std::uint64_t seed_;
  OutlineTracer tracer_;
  CircleVoter voter_;
  InnerEdges inner_edges_;
  InnerCircles inner_circles_;
  BallVerifier verifier_;
  RegionOutline unexplained_;  // what no circle of a region explains yet
  std::vector<InnerEdge> inside_;
};

}  // namespace ballservo
