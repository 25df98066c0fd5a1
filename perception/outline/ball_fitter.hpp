// Stages 5 and 6: from a supposed outline to a ball in space, by the edges around it.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "calibration/camera/ray_table.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/outline/edge_points.hpp"
#include "perception/outline/fitted_ball.hpp"

namespace ballservo {

/// One step was enough where the next one, on the same points, would be no longer than this: the
/// comparison's tolerance, below the threshold of 0.059 px that its certificate finds for the paper's step,
/// which on other conditions catches 98 % of the breaks at 4 % false alarms (`ballservo compare
/// data/comparisons/paper.yaml`, certificate.csv).
inline constexpr double enough_next_step_px = 0.05;

/// Fits balls in the pictures of one camera. Each fit says all in `fit`, which means nothing where it is
/// false: no edge of a ball is there.
class BallFitter {
 public:
  /// `oval_fraction`: see one_gauss_newton_step.
  explicit BallFitter(std::shared_ptr<const RayTable> rays, double oval_fraction = 0)
      : rays_(std::move(rays)), oval_fraction_(oval_fraction) {}

  /// The exact cone, by the edges around `start`, which is known to a pixel or so.
  bool fit_sphere(const cv::Mat& bgr, const CameraResponse& response, const TangentCone& start,
                  const BallRadius& radius, OutlineFit& fit);

  /// The paper's: one step of the circle on the pixels around it, and the paper's formula.
  bool fit_circle(const cv::Mat& bgr, const UndistortedCircle& start, const BallRadius& radius,
                  OutlineFit& fit) const;

  /// What the edges of a ball say of the camera. `response` is the one under which they are measured.
  ResponseEvidence response_evidence(const cv::Mat& bgr, const CameraResponse& response,
                                     const TangentCone& cone);

 private:
  void measure(const cv::Mat& bgr, const CameraResponse& response, const TangentCone& cone,
               OutlineEdges& edges);
  bool finish(const UndistortedCircle& start, OutlineFit& fit) const;

  std::shared_ptr<const RayTable> rays_;
  double oval_fraction_;
  EdgeMeter edge_meter_;
  RobustWeights robust_weights_;
  OutlineEdges evident_edges_;
};

}  // namespace ballservo
