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
#include "perception/ball_fitter.hpp"
#include "perception/ball_observation.hpp"
#include "perception/boundary_chain.hpp"
#include "perception/boundary_cone.hpp"
#include "perception/circle_vote.hpp"
#include "perception/color_lookup.hpp"
#include "perception/detection_stages.hpp"
#include "perception/detector_options.hpp"
#include "perception/inner_circles.hpp"
#include "perception/inner_edges.hpp"
#include "perception/morphology.hpp"
#include "perception/outline_scout.hpp"
#include "perception/regions.hpp"
#include "perception/row_team.hpp"
#include "perception/straight_sides.hpp"

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
};

class Detector {
 public:
  Detector(std::shared_ptr<const RayTable> rays, std::shared_ptr<const ColorTable> colors,
           const DetectorOptions& options);

  /// The balls in a picture (8-bit BGR, of the camera's size), best first. Looks only at `window` (empty:
  /// everywhere). Throws InputError for a picture of another size or type.
  const std::vector<BallObservation>& detect(const cv::Mat& bgr, cv::Rect window = {},
                                             DetectionStages* stages = nullptr);

  /// The expected ball, by the edges around it and without votes; nothing where they show none. Looks at the
  /// colours in `window` only, which holds its outline. A ball that passes as any does (`clearly`), or also
  /// one whose colour and outline say less, as where its rim is dark or held. Of several the clearest that
  /// `may_be` it.
  std::optional<BallObservation> find_expected(
      const cv::Mat& bgr, const cv::Rect& window, const ExpectedBall& expected, bool clearly,
      const std::function<bool(const BallObservation&)>& may_be = [](const auto&) { return true; });

  const DetectorOptions& options() const { return options_; }
  /// Lets weaker balls through (a tracker knows where one must be), or fewer.
  void set_min_quality(double min_quality) { options_.min_quality = min_quality; }
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
  static constexpr double sure_quality = 0.7;
  struct Candidate {
    std::optional<BallObservation> ball;
    OutlineSupport support;
    const char* reason = nullptr;  // why it is no ball
    bool is_sure() const { return !reason && ball->quality >= sure_quality; }
  };
  void check(const cv::Mat& bgr) const;
  void segment(const cv::Mat& bgr, const cv::Rect& window);
  void collect_boundary(const ColoredPixels& colored, int region);
  Candidate judge(const cv::Mat& bgr, const ColoredPixels& colored, const CircleEstimate& vote,
                  RefinementInput* input, bool inside_region = false);
  void look_around(const cv::Mat& bgr, const ColoredPixels& colored, const CircleEstimate& vote,
                   Candidate& candidate, RefinementInput* input);
  std::optional<BallObservation> find_from(const cv::Mat& bgr, const ColoredPixels& colored,
                                           const TangentCone& start, double reach_px, bool clearly);
  bool encloses_region(const BallObservation& ball) const;
  Candidate judge_scouted(const cv::Mat& bgr, const ColoredPixels& colored, const TangentCone& start,
                          double reach_px, double min_edge, RefinementInput* input);
  void judge_fitted(const cv::Mat& bgr, const ColoredPixels& colored, Candidate& candidate);
  OutlineSupport early_support(const cv::Mat& bgr, const ColoredPixels& colored,
                               const TangentCone& cone) const;
  const char* early_rejection(const OutlineSupport& support) const;
  bool take_away(const CircleEstimate& vote, const BallObservation* ball, DetectionStages* stages);
  void record(int region, const CircleEstimate& vote, const Candidate& candidate,
              const RefinementInput& input, DetectionStages& stages) const;
  void vote_for_balls(const cv::Mat& bgr, const ColoredPixels& colored, int region, DetectionStages* stages);
  void look_inside(const cv::Mat& bgr, const ColoredPixels& colored, int region, std::size_t first_known,
                   DetectionStages* stages);
  void find_balls(const cv::Mat& bgr, const cv::Rect& window, DetectionStages* stages);
  void find_balls_in(const cv::Mat& bgr, const cv::Rect& window, int region, DetectionStages* stages);
  const char* rejection(const BallObservation& ball) const;
  bool shows_a_sphere(const cv::Mat& bgr, const ColoredPixels& colored, const BallObservation& ball) const;
  double share_on_outline(const BallObservation& ball) const;
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
