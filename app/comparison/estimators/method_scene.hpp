// What every method of a comparison is handed: a picture, a starting circle, and the points around it.
#pragma once

#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "app/comparison/estimators/converged_fits.hpp"
#include "app/comparison/estimators/methods.hpp"
#include "app/comparison/estimators/peers.hpp"
#include "perception/detector.hpp"

namespace ballservo {

/// What a comparison tells its methods beside the picture.
struct MethodTask {
  ClassIndex color_class = 1;
  RobustLoss loss{RobustLossKind::cauchy, 0.3};  ///< of the robust fits
  PeerSettings peers;
  int hue = 0;  ///< of the ball, as OpenCV counts it: for peers that go by colour
  /// What a peer is told of the ball's size, and where a user would click; not known: such peers do not run.
  std::optional<double> expected_radius_px;
  std::optional<Eigen::Vector2d> click_px;
  /// Where there are several candidates, the one nearest to this place (px) is meant; otherwise each method's
  /// own best.
  std::optional<Eigen::Vector2d> near_px;
  /// In place of the voted circle (undistorted, relative to the principal point).
  std::optional<UndistortedCircle> start;
};

/// What the detectors of one picture are made of; the ball's radius must be among the options.
struct DetectorSetup {
  std::shared_ptr<const RayTable> rays;
  std::shared_ptr<const ColorTable> colors;
  DetectorOptions options;
  /// What a whole detector is shown first: it learns the camera's response from the balls that it sees.
  std::vector<cv::Mat> seen_before{};
};

/// One picture for all methods. The ball is the detector's best of the task's class.
class MethodScene {
 public:
  MethodScene(const cv::Mat& bgr, const DetectorSetup& setup, const MethodTask& task);

  const cv::Mat& bgr() const { return bgr_; }
  const MethodTask& task() const { return task_; }
  const Camera& camera() const { return detector_.rays().camera(); }
  const RayTable& rays() const { return detector_.rays(); }
  double radius_m() const { return radius_m_; }

  /// What the votes said of the detector's own ball, whatever the methods start from.
  const std::optional<CircleEstimate>& vote() const { return vote_; }
  /// Every ball of the task's class that a detector with the given fit reports, best first.
  std::vector<MethodFit> detections(BallFit fit);
  /// Makes what methods share, so that their own time is theirs alone, and keeps how long that took.
  void prepare(MethodPoints points);
  /// How long that took, where it is part of every method's time; else 0.
  double shared_us(MethodPoints points) const;
  /// Where the fits start: the votes' circle, or the task's. Nothing: no ball was found, and none was told.
  const std::optional<UndistortedCircle>& start() const { return start_; }

  /// The paper's points: the ring's pixels, from the starting circle.
  const std::vector<RingPixel>& ring();
  /// The exact fit's points, and the cone of its last step's start. Nothing where there are none.
  struct Edges {
    TangentCone start;
    std::vector<EdgePoint> points;
    int passes = 1;  ///< how often they were measured: again after a long step
  };
  const std::optional<Edges>& edges();

  /// What a circle of the undistorted picture, a cone, or a circle in the picture as given, says of the ball.
  std::optional<MethodFit> answer(const UndistortedCircle& circle) const;
  std::optional<MethodFit> answer(const TangentCone& cone) const;
  std::optional<MethodFit> answer(const OutlineEllipse& circle) const;

 private:
  MethodFit answer(const OutlineEllipse& outline, const Eigen::Vector3d& p_C) const;
  Detector& whole_detector(BallFit fit);

  const cv::Mat& bgr_;
  const DetectorSetup& setup_;
  Detector detector_;
  MethodTask task_;
  double radius_m_ = 0;
  std::map<BallFit, Detector> whole_;
  std::optional<CircleEstimate> vote_;
  std::optional<UndistortedCircle> start_;
  std::vector<BoundaryPoint> boundary_;
  std::map<MethodPoints, double> cost_us_;  // of what is made
  std::vector<RingPixel> ring_;
  std::optional<Edges> edges_;
};

/// A circle in the picture as given (px) as it is in the undistorted picture: mean of its points' places, and
/// of their distances from it. Nothing where a point has no ray.
std::optional<UndistortedCircle> undistorted_circle(const Camera& camera, const OutlineEllipse& circle);

}  // namespace ballservo
