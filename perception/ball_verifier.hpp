// Is a supposed circle or cone a ball? Its outline fitted, and the fit judged.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/ball_observation.hpp"
#include "perception/candidates/outline_scout.hpp"
#include "perception/detector_options.hpp"
#include "perception/judgement/ball_judge.hpp"
#include "perception/judgement/second_look.hpp"
#include "perception/outline/ball_fitter.hpp"
#include "perception/outline/cone_fit.hpp"

namespace ballservo {

/// A circle that votes gave, and the cone that it would be; none where no ball makes it.
struct VotedCircle {
  VotedCircle(const CircleEstimate& voted, double focal_px);

  CircleEstimate estimate;
  std::optional<TangentCone> cone;
};

/// What became of a supposed ball.
struct VerifiedCandidate {
  bool is_fitted = false;  ///< without it, `fit` shows the points of a fit that failed, if any
  OutlineFit fit;
  Verdict verdict;
  double log_odds = 0;  ///< by a second look, where there was one

  bool is_ball() const { return verdict.reason == nullptr; }
  /// Of what was fitted.
  BallObservation observation(ClassIndex color_class, const std::optional<CircleEstimate>& vote) const;
};

/// Candidates are valid until the next one is verified.
class BallVerifier {
 public:
  BallVerifier(std::shared_ptr<const RayTable> rays, const DetectorOptions& options);

  /// By the points that the circle was voted from. Most circles are no balls: the cheap questions come first,
  /// but for those that edges inside a region speak for, whose boundary says little.
  const VerifiedCandidate& verify(const ClassView& view, const VotedCircle& circle,
                                  const std::vector<BoundaryPoint>& points, bool inside_region = false);

  /// The same, and the outline around the region in its place where that says more: a region may be less than
  /// its ball, whose rim is too dark or too pale for the class. `region` is its whole boundary.
  const VerifiedCandidate& verify_frayed(const ClassView& view, const VotedCircle& circle,
                                         const std::vector<BoundaryPoint>& points,
                                         const std::vector<BoundaryPoint>& region);

  /// The ball whose outline is near the cone's, by the edges in the picture alone; nothing where there is
  /// none. Not `clearly`: also one that shows less of itself than another must, its size held to what is
  /// `known`.
  std::optional<BallObservation> verify_near(const ClassView& view, const TangentCone& start, double reach_px,
                                             bool clearly, const KnownAngle& known);

  /// The exact fit of a circle that has a cone, and its points, as of every candidate.
  bool fit_sphere(BallFitter& fitter, const cv::Mat& bgr, const CameraResponse& response,
                  const VotedCircle& circle, const TangentCone& rough,
                  const std::vector<BoundaryPoint>& points, const BallRadius& radius, OutlineFit& fit);
  TangentCone rough_cone(const VotedCircle& circle, const std::vector<BoundaryPoint>& points) {
    return boundary_cone_.rough(*circle.cone, points, rays_->camera().focal_px());
  }
  BallFitter& fitter() { return fitter_; }
  SecondLook& second_look() { return second_look_; }

 private:
  template <typename FitBy>  // bool(BallFitter&, OutlineFit&)
  void fit_and_judge(const ClassView& view, const std::vector<BoundaryPoint>& points,
                     VerifiedCandidate& candidate, const FitBy& fit_by);
  void fit_near(const ClassView& view, const TangentCone& start, double reach_px, double min_edge,
                VerifiedCandidate& candidate, const KnownAngle& known = {});
  const VerifiedCandidate& looked_at_again(const ClassView& view, VerifiedCandidate& candidate);
  bool fit_seen(const ClassView& view, const SecondLook::Look& look, VerifiedCandidate& candidate);
  bool is_seen_ball(const ClassView& view, const VerifiedCandidate& candidate);
  BallJudge judge(const ClassView& view) const { return {view, *rays_}; }
  BallRadius radius(const ClassView& view) const { return options_.radius_of(view.colored.color_class); }

  std::shared_ptr<const RayTable> rays_;
  DetectorOptions options_;
  BoundaryCone boundary_cone_;
  BallFitter fitter_, oval_fitter_;
  ScoutedOutline scouted_;
  SecondLook second_look_;
  VerifiedCandidate voted_, around_, oval_, seen_;
};

}  // namespace ballservo
