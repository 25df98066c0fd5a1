// The paper's on-line pipeline for one picture; `Detector::detect` is where to read it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "calibration/circles/circle_vote.hpp"
#include "perception/candidates/inner_circles.hpp"
#include "perception/candidates/inner_edges.hpp"
#include "perception/candidates/outline_scout.hpp"
#include "perception/candidates/straight_sides.hpp"
#include "perception/detection_stages.hpp"
#include "perception/detector_options.hpp"
#include "perception/judgement/ball_judge.hpp"
#include "perception/outline/ball_fitter.hpp"
#include "perception/outline/ball_observation.hpp"
#include "perception/outline/boundary_cone.hpp"
#include "perception/segmentation/boundary_chain.hpp"
#include "perception/segmentation/color_lookup.hpp"
#include "perception/segmentation/morphology.hpp"
#include "perception/segmentation/regions.hpp"
#include "perception/segmentation/row_team.hpp"

namespace ballservo {

/// What a look had too much of, so that its cost is bounded: noise or a fine pattern of a ball's colour.
struct LeftOut {
  int regions = 0;     ///< smaller ones, not looked at
  int shorter_px = 0;  ///< runs of a class shorter than this, taken for background
  /// Of several looks at one picture: the most that one of them left out.
  void add(const LeftOut& look) {
    regions = std::max(regions, look.regions);
    shorter_px = std::max(shorter_px, look.shorter_px);
  }
  explicit operator bool() const { return regions > 0 || shorter_px > 0; }
};

/// Where a ball is expected: its outline within `reach_px` of the cone's, nearly in its size; or of such
/// cones side by side, up to `spread_px` to each side.
struct ExpectedBall {
  ClassIndex color_class = no_class;
  TangentCone cone;
  double reach_px = 5, spread_px = 0;
  std::optional<double> min_quality{};  ///< that suffices here; nothing: the detector's own
};

class Detector {
 public:
  Detector(std::shared_ptr<const RayTable> rays, std::shared_ptr<const ColorTable> colors,
           const DetectorOptions& options);

  /// The balls in a picture (8-bit BGR, of the camera's size), best first. Looks only at `window` (empty:
  /// everywhere). Lets weaker balls through than the options say, or fewer, by a `min_quality` of this look.
  /// Throws InputError for a picture of another size or type.
  const std::vector<BallObservation>& detect(const cv::Mat& bgr, cv::Rect window = {},
                                             DetectionStages* stages = nullptr,
                                             std::optional<double> min_quality = std::nullopt);

  /// The expected ball, by the edges around it and without votes; nothing where they show none. Looks at the
  /// colours in `window` only, which holds its outline. A ball that passes as any does (`clearly`), or also
  /// one whose colour and outline say less, as where its rim is dark or held. Of several the clearest that
  /// `may_be` it.
  std::optional<BallObservation> find_expected(
      const cv::Mat& bgr, const cv::Rect& window, const ExpectedBall& expected, bool clearly,
      const std::function<bool(const BallObservation&)>& may_be = [](const auto&) { return true; });

  const DetectorOptions& options() const { return options_; }
  const RayTable& rays() const { return *rays_; }
  const ColorTable& colors() const { return colors_.colors(); }
  /// Looks colours up for another light than the taught one.
  void set_light(const LightCells& light) { colors_.set_light(light); }
  /// What there was too much of for the last `detect` to look at.
  const LeftOut& left_out() const { return left_out_; }

  /// Fits the balls, as `detect` does.
  BallFitter& fitter() { return fitter_; }
  const BallFitter& fitter() const { return fitter_; }

 private:
  struct Candidate {
    std::optional<BallObservation> ball;
    OutlineSupport support;
    const char* reason = nullptr;  // why it is no ball
  };
  // A circle that votes gave, and the cone that it would be; none where no ball makes it.
  struct VotedCircle {
    CircleEstimate estimate;
    std::optional<TangentCone> cone;
  };
  // One class in a picture.
  struct Look {
    const cv::Mat& bgr;
    const ColoredPixels& colored;
    BallJudge judge;
  };
  void check(const cv::Mat& bgr) const;
  Look look_at(const cv::Mat& bgr, const ColoredPixels& colored, std::optional<double> min_quality) const;
  VotedCircle voted_circle(const CircleEstimate& estimate) const;
  void segment(const cv::Mat& bgr, const cv::Rect& window);
  void collect_boundary(const ColoredPixels& colored, int region);
  Candidate try_circle(const Look& look, const VotedCircle& circle, RefinementInput* input,
                       bool inside_region = false);
  Candidate try_around(const Look& look, const TangentCone& start, double reach_px, double min_edge,
                       RefinementInput* input);
  void judge_fitted(const Look& look, Candidate& candidate) const;
  void look_around(const Look& look, const VotedCircle& circle, Candidate& candidate, RefinementInput* input);
  std::optional<BallObservation> find_from(const Look& look, const TangentCone& start, double reach_px,
                                           bool clearly);
  bool take_away(const CircleEstimate& vote, const BallObservation* ball, DetectionStages* stages);
  void record(int region, const VotedCircle& circle, const Candidate& candidate, const RefinementInput& input,
              DetectionStages& stages) const;
  void find_balls(const cv::Mat& bgr, const cv::Rect& window, std::optional<double> min_quality,
                  DetectionStages* stages);
  void vote_for_balls(const Look& look, int region, DetectionStages* stages);
  void look_inside(const Look& look, int region, std::size_t first_known, DetectionStages* stages);
  void drop_repeated();

  std::shared_ptr<const RayTable> rays_;
  ColorLookup colors_;
  DetectorOptions options_;
  std::unique_ptr<RowTeam> team_;  // nothing for one thread
  LeftOut left_out_;
  // Reused between pictures.
  ClassPictures classified_, opened_, closed_;
  std::vector<int> chosen_;  // regions
  ClassMorphology morphology_;
  RegionMap regions_;
  BoundaryChain chain_;
  StraightSides sides_;
  CircleVoter voter_;
  InnerEdges inner_edges_;
  InnerCircles inner_circles_;
  BallFitter fitter_;
  BoundaryCone boundary_cone_;
  ScoutedOutline scouted_;
  std::vector<BoundaryPixel> boundary_, remaining_;
  std::vector<BoundaryPoint> points_, whole_boundary_;
  std::vector<InnerEdge> inside_;
  std::vector<BallObservation> balls_;
};

}  // namespace ballservo
