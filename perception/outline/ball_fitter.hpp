// Stages 5 and 6: from a supposed outline to a ball in space, by the edges around it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/outline/cone_fit.hpp"
#include "perception/outline/edge_points.hpp"
#include "perception/outline/paper_refinement.hpp"

namespace ballservo {

/// The two ways to fit a ball: the exact tangent cone, or the paper's circle with the paper's formula.
enum class BallFit { sphere, paper };

/// The ball's radius as the user states it (m); 0: not known.
struct BallRadius {
  double radius_m = 0;
  double sigma_m = 0;
};

/// A position in 3-D with its covariance.
struct BallPosition {
  Eigen::Vector3d p_C{0, 0, 0};                                 ///< centre, camera frame, m
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  ///< m^2
};

struct FittedBall {
  OutlineEllipse outline;  ///< in the picture as given
  TangentCone cone;        ///< direction and angular radius, camera frame
  Eigen::Matrix3d cone_covariance_rad2 = Eigen::Matrix3d::Zero();  ///< of (turn, turn, alpha), see ConeFit
  std::optional<BallPosition> position;  ///< where the camera and the radius are known
  UndistortedCircle start;  ///< where the fit started: the votes' circle, or an outline that edges show
  double residual_px = 0;   ///< RMS distance of the edge from the outline
  double step_px = 0;       ///< length of the last Gauss-Newton step
  double next_step_px = 0;  ///< of the step that would follow it on the same points: what stopping leaves
  bool one_step_enough = false;  ///< that is less than would matter: see enough_next_step_px
  double blur_px = 0;            ///< of the edge; 0 where it was not measured
};

/// A fitted ball with the points of its last step. Reused: its vectors keep their memory.
struct OutlineFit {
  FittedBall ball;
  // Fit sphere:
  TangentCone edges_start;  ///< the cone around which the edges were measured
  double oval = 0;          ///< how far the outline departs from the ball's, a part of its radius
  int passes = 0;           ///< how often they were measured, each time for one step
  OutlineEdges edges;
  EdgeOffsets offsets;  ///< of the edges from the fitted outline; no sectors where none were measured
  // Fit paper:
  std::vector<RingPixel> ring;

  bool has_edges() const { return offsets.count > 0; }
  void clear() {
    ball = {};
    edges.points.clear();
    offsets.count = 0;
    ring.clear();
  }
};

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
  double oval_fraction() const { return oval_fraction_; }

  /// The exact cone, by the edges around `start`, which is known to a pixel or so.
  bool fit_sphere(const cv::Mat& bgr, const CameraResponse& response, const TangentCone& start,
                  const BallRadius& radius, OutlineFit& fit, const KnownAngle& known = {});

  /// The paper's: one step of the circle on the pixels around it, and the paper's formula.
  bool fit_circle(const cv::Mat& bgr, const UndistortedCircle& start, const BallRadius& radius,
                  OutlineFit& fit) const;

  /// The response may be `other` with that probability, and the ball is elsewhere then: adds this to the
  /// covariances of a ball that `fit_sphere` has fitted.
  void admit(const CameraResponse& other, double probability, const cv::Mat& bgr, const BallRadius& radius,
             FittedBall& ball);

  /// What the edges of a ball say of the camera. `response` is the one under which they are measured.
  ResponseEvidence response_evidence(const cv::Mat& bgr, const CameraResponse& response,
                                     const TangentCone& cone);

 private:
  void measure(const cv::Mat& bgr, const CameraResponse& response, const TangentCone& cone,
               OutlineEdges& edges, const KnownAngle& known = {});
  bool finish(const UndistortedCircle& start, OutlineFit& fit) const;

  std::shared_ptr<const RayTable> rays_;
  double oval_fraction_;
  EdgeMeter edge_meter_;
  RobustWeights robust_weights_;
  OutlineEdges evident_edges_;
};

}  // namespace ballservo
