// Stages 5 and 6: from a voted circle to a ball in space, by the edges around it.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "perception/detector_options.hpp"
#include "perception/outline/ball_observation.hpp"
#include "perception/outline/boundary_cone.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/outline/edge_points.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// One step was enough where the next one, on the same points, would be no longer than this: the
/// comparison's tolerance, below the threshold of 0.059 px that its certificate finds for the paper's step,
/// which on other conditions catches 98 % of the breaks at 4 % false alarms (`ballservo compare
/// data/comparisons/paper.yaml`, certificate.csv).
inline constexpr double enough_next_step_px = 0.05;

/// What the last refinement of a candidate started from and used: the material of one-step against converged
/// fits.
struct RefinementInput {
  std::vector<RingPixel> ring;   ///< fit paper: the pixels and weights of the step
  TangentCone start;             ///< fit sphere: where the last step started
  std::vector<EdgePoint> edges;  ///< fit sphere: the points and weights of the last step
  int passes = 0;                ///< fit sphere: how often the edges were measured, each time for one step
};

/// Fits balls in the pictures of one camera, whose response it learns; keeps its buffers between calls.
class BallFitter {
 public:
  BallFitter(std::shared_ptr<const RayTable> rays, const DetectorOptions& options);

  /// Refines one voted circle, whose cone_near_circle is `voted`, with the boundary points it was voted from;
  /// nothing where there is no ball's
  /// edge. What of an observation tells whether it is a ball is left open. `input` receives what was used.
  std::optional<BallObservation> refine(const cv::Mat& bgr, ClassIndex color_class,
                                        const CircleEstimate& vote, const TangentCone& voted,
                                        const std::vector<BoundaryPoint>& boundary, BallFit fit,
                                        RefinementInput* input = nullptr);

  /// Refines a sphere's cone that is known to a pixel or so, by the edges around it alone.
  std::optional<BallObservation> refine(const cv::Mat& bgr, ClassIndex color_class, const TangentCone& start,
                                        RefinementInput* input = nullptr);

  /// Of the last ball that `refine` fitted as a sphere.
  const OutlineEdges& edges() const { return edges_; }
  const EdgeOffsets& offsets() const { return offsets_; }

  /// The radius that the user stated for a class; 0 where it is not known.
  BallRadius radius_of(ClassIndex color_class) const;

  /// How the camera's grey levels follow the light, as stated or as believed by now.
  const CameraResponse& response() const;
  /// Looks at the edges of balls that were found. Is another response believed now?
  bool learn_response(const cv::Mat& bgr, const std::vector<BallObservation>& balls);
  /// The next picture may be another camera's.
  void forget_response() { belief_ = {}; }

 private:
  std::optional<BallObservation> refine_sphere(const cv::Mat& bgr, ClassIndex color_class, TangentCone cone,
                                               RefinementInput* input);
  std::optional<BallObservation> refine_paper(const cv::Mat& bgr, ClassIndex color_class,
                                              const UndistortedCircle& circle, RefinementInput* input);
  std::optional<BallObservation> finished(std::optional<BallObservation> ball, ClassIndex color_class,
                                          const UndistortedCircle& start) const;
  void measure(const cv::Mat& bgr, const TangentCone& cone);
  std::optional<BallPosition> position(ClassIndex color_class, const ConeFit& fit) const;

  std::shared_ptr<const RayTable> rays_;
  DetectorOptions options_;
  ResponseBelief belief_;
  BoundaryCone boundary_cone_;
  EdgeMeter edge_meter_;
  OutlineEdges edges_;
  EdgeOffsets offsets_;
  RobustWeights robust_weights_;
  std::vector<RingPixel> ring_;
};

}  // namespace ballservo
