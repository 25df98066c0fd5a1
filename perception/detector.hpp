// The paper's on-line pipeline for one picture; `Detector::detect` is where to read it.
#pragma once

#include <algorithm>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/ray_table.hpp"
#include "perception/ball_observation.hpp"
#include "perception/detection_stages.hpp"
#include "perception/detector_options.hpp"
#include "perception/judgement/clear_ball.hpp"
#include "perception/outline/camera_response.hpp"
#include "perception/region_search.hpp"
#include "perception/segmentation/classification.hpp"
#include "perception/segmentation/morphology.hpp"
#include "perception/segmentation/regions.hpp"
#include "perception/segmentation/smoothing.hpp"

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
  double min_quality = min_ball_quality;  ///< that suffices here
  double size_sigma = 0;  ///< of the logarithm of its size, which its outline is held to; 0: free
};

class Detector {
 public:
  Detector(std::shared_ptr<const RayTable> rays, std::shared_ptr<const ColorTable> colors,
           const DetectorOptions& options);

  /// The balls in a picture (8-bit BGR, of the camera's size), best first. Looks only at `window` (empty:
  /// everywhere, and doubtful balls are looked at again). Throws InputError for a picture of another size or
  /// type.
  const std::vector<BallObservation>& detect(const cv::Mat& bgr, const cv::Rect& window = {},
                                             DetectionStages* stages = nullptr,
                                             double min_quality = min_ball_quality);

  /// For the picture in which `detect` has just looked, where it looked: its balls, and those that show too
  /// little of their outlines, by the colours of their pixels. Slower.
  const std::vector<BallObservation>& detect_thoroughly(const cv::Mat& bgr,
                                                        DetectionStages* stages = nullptr);

  /// The expected ball, by the edges around it and without votes; nothing where they show none. Looks at the
  /// colours in `window` only, which holds its outline. A ball that passes as any does (`clearly`), or also
  /// one whose colour and outline say less, as where its rim is dark or held. Of several the clearest that
  /// `may_be` it.
  std::optional<BallObservation> find_expected(
      const cv::Mat& bgr, const cv::Rect& window, const ExpectedBall& expected, bool clearly,
      const std::function<bool(const BallObservation&)>& may_be = [](const auto&) { return true; });

  /// The like for another table.
  Detector with_colors(std::shared_ptr<const ColorTable> colors) const {
    return {rays_, std::move(colors), options_};
  }

  const DetectorOptions& options() const { return options_; }
  const RayTable& rays() const { return *rays_; }
  const ColorTable& colors() const { return colors_.colors(); }
  /// Looks colours up for another light than the taught one.
  void set_light(const LightCells& light) {
    colors_.set_light(light);
    search_.verifier().second_look().set_light(light);
  }
  /// What there was too much of for the last `detect` to look at.
  const LeftOut& left_out() const { return left_out_; }

  /// The logarithm of the odds that what was found in the picture is a ball, by the colours of its pixels.
  double log_odds(const cv::Mat& bgr, const BallObservation& ball);

  /// The exact fit that `detect` makes from a voted circle and the boundary points that it was voted from; of
  /// a ball of unknown radius.
  bool fit_sphere(const cv::Mat& bgr, const UndistortedCircle& circle,
                  const std::vector<BoundaryPoint>& boundary, OutlineFit& fit);

  /// How the camera's grey levels follow the light, as stated or as believed by now.
  const CameraResponse& response() const;
  /// For a picture that may be another camera's than those before.
  void forget_response() { response_belief_ = ResponseBelief(options_.coarse_chroma); }

 private:
  // A window as classified, without specks, and without holes.
  struct Segmented {
    ClassPictures classified, opened, closed;
  };
  void check(const cv::Mat& bgr) const;
  const std::vector<BallObservation>& search_regions(const cv::Mat& bgr, const RegionPrior& prior,
                                                     DetectionStages* stages);
  void find_balls(const cv::Mat& bgr, RegionPrior prior, DetectionStages* stages);
  void compare_with_clear_balls(const cv::Mat& bgr, DetectionStages* stages);
  void learn_noise(const cv::Mat& bgr);
  void segment(const cv::Mat& bgr, const cv::Rect& window);
  bool learn_response(const cv::Mat& bgr);
  void admit_other_responses(const cv::Mat& bgr);

  std::shared_ptr<const RayTable> rays_;
  DetectorOptions options_;
  double most_noise_;  // (sigma, grey levels) in which colours are told from the picture itself
  ColorLookup colors_;
  double noise_sigma_ = 0;  // of the last picture that was searched everywhere
  Smoothing smoothing_;
  ClassMorphology morphology_;
  Segmented segmented_;
  RegionMap regions_;
  std::vector<int> chosen_;  // regions
  struct {
    cv::Rect window;
    bool everywhere = true;
  } looked_at_;
  RegionSearch search_;
  ResponseBelief response_belief_;
  std::vector<BallObservation> balls_;
  std::vector<BallLooks> looks_;  // of `balls_`
  LeftOut left_out_;
};

}  // namespace ballservo
