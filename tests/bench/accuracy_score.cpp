#include "tests/bench/accuracy_score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "app/comparison/comparison_statistics.hpp"
#include "app/comparison/estimators/opencv_peers.hpp"
#include "app/comparison/estimators/position_bound.hpp"
#include "app/report/overlay.hpp"
#include "calibration/base/statistics.hpp"
#include "perception/detector.hpp"
#include "perception/outline/ball_position.hpp"

namespace ballservo::bench {
namespace {

constexpr double chi2_95_of_3 = 7.815;
constexpr std::size_t failures_kept = 6;

struct Candidate {
  OutlineEllipse outline;
  Eigen::Vector3d p_C{0, 0, 0};
  const BallObservation* ball = nullptr;  // ours
};

// A peer's circle becomes a position by the paper's formula: square pixels, no distortion.
std::vector<Candidate> from_circles(const Camera& camera, const std::vector<OutlineEllipse>& circles) {
  std::vector<Candidate> candidates;
  const CameraParameters& k = camera.parameters();
  for (const OutlineEllipse& circle : circles) {
    Candidate candidate;
    candidate.outline = circle;
    candidate.p_C = paper_position({circle.center_px - Eigen::Vector2d(k.cx_px, k.cy_px), circle.radius_px},
                                   camera.focal_px(), accuracy_ball_radius_m);
    candidates.push_back(candidate);
  }
  return candidates;
}

std::vector<Candidate> from_balls(const std::vector<BallObservation>& balls) {
  std::vector<Candidate> candidates;
  for (const BallObservation& ball : balls) candidates.push_back({ball.outline, ball.position->p_C, &ball});
  return candidates;
}

FrameScore score(const AccuracyFrame& frame, const std::vector<Candidate>& candidates) {
  FrameScore result;
  const Candidate* best = nullptr;
  double best_px = 0;
  for (const Candidate& candidate : candidates) {
    if (!frame.truth) break;
    const double apart_px = (candidate.outline.center_px - frame.truth->center_px).norm();
    const double larger_px = candidate.outline.radius_px - frame.truth->radius_px;
    const double allowed_px = 0.2 * frame.truth->radius_px;
    if (apart_px > allowed_px || std::abs(larger_px) > allowed_px || (best && apart_px >= best_px)) continue;
    best = &candidate;
    best_px = apart_px;
    result.radius_px = larger_px;
  }
  result.false_balls = static_cast<int>(candidates.size()) - (best ? 1 : 0);
  if (!best) return result;
  result.found = true;
  result.center_px = best_px;
  result.error_C = best->p_C - frame.p_CB;
  if (!best->ball) return result;
  const BallObservation& ball = *best->ball;
  const Eigen::Matrix3d& covariance = ball.position->covariance_m2;
  result.nees = result.error_C.dot(covariance.ldlt().solve(result.error_C));
  const Eigen::Vector3d away = best->p_C.normalized();
  result.sigma_depth_m = std::sqrt(away.dot(covariance * away));
  result.quality = ball.quality;
  result.residual_px = ball.residual_px;
  result.blur_px = ball.blur_px;
  result.arc = ball.support.arc;
  return result;
}

cv::Mat shown(const AccuracyFrame& frame, const std::vector<BallObservation>& balls, const Camera& camera) {
  cv::Mat picture = frame.bgr.clone();
  for (const BallObservation& ball : balls) draw_ball(picture, camera, ball, "", {255, 255, 255});
  return picture;
}

double bound_m(const AccuracyCondition& condition, const Camera& camera, const AccuracyFrame& frame) {
  if (!frame.truth) return std::nan("");
  const auto covariance = position_bound({camera, frame.p_CB, accuracy_ball_radius_m, condition.blur_px,
                                          condition.noise, 0, frame.clean_bgr, frame.unhidden});
  return covariance ? std::sqrt(covariance->trace()) : std::nan("");
}

class Methods {
 public:
  explicit Methods(const AccuracyCondition& condition)
      : camera_(accuracy_camera(condition)),
        sphere_(detector(condition, BallFit::sphere)),
        paper_(detector(condition, BallFit::paper)),
        hough_(accuracy_ball_radius_m / condition.depth_m * camera_.focal_px()),
        hsv_(accuracy_hue(condition)) {}

  std::array<FrameScore, all_accuracy_methods.size()> run(const AccuracyFrame& frame) {
    return {score(frame, from_balls(sphere_.detect(frame.bgr))),
            score(frame, from_balls(paper_.detect(frame.bgr))),
            score(frame, from_circles(camera_, hough_.find(frame.bgr))),
            score(frame, from_circles(camera_, hsv_.find(frame.bgr)))};
  }
  cv::Mat picture(const AccuracyFrame& frame) { return shown(frame, sphere_.detect(frame.bgr), camera_); }

 private:
  Detector detector(const AccuracyCondition& condition, BallFit fit) const {
    DetectorOptions options;
    options.fit = fit;
    options.radii = {{accuracy_ball_radius_m, 0}};
    return Detector(std::make_shared<const RayTable>(camera_), accuracy_colors(condition), options);
  }
  Camera camera_;
  Detector sphere_, paper_;
  HoughGradient hough_;
  HsvContour hsv_;
};

}  // namespace

const char* accuracy_method_name(AccuracyMethod method) {
  constexpr std::array<const char*, all_accuracy_methods.size()> names{"sphere", "paper", "hough_gradient",
                                                                       "hsv_contour"};
  return names[static_cast<std::size_t>(method)];
}

ConditionScores score_condition(const AccuracyCondition& condition, std::uint64_t seed, int frames,
                                const std::function<void()>& on_frame) {
  ConditionScores scores;
  scores.condition = &condition;
  Methods methods(condition);
  const Camera camera = accuracy_camera(condition);
  for (int k = 0; k < frames; ++k) {
    const AccuracyFrame frame = make_accuracy_frame(condition, seed, k);
    scores.frames.push_back(methods.run(frame));
    scores.bounds_m.push_back(bound_m(condition, camera, frame));
    const FrameScore& ours = scores.frames.back().front();
    if (k == 0) scores.example = methods.picture(frame);
    const bool wrong = (frame.truth && !ours.found) || ours.false_balls > 0;
    if (wrong && scores.failures.size() < failures_kept)
      scores.failures.emplace_back(k, methods.picture(frame));
    on_frame();
  }
  return scores;
}

MethodSummary summarize(const ConditionScores& scores, AccuracyMethod method) {
  MethodSummary summary;
  std::vector<double> center_px, radius_px, position_mm;
  double squares_mm2 = 0, nees = 0;
  double bounded_squares_mm2 = 0, bound_squares_mm2 = 0;  // of the frames with a bound
  int within = 0, bounded = 0;
  for (std::size_t k = 0; k < scores.frames.size(); ++k) {
    const FrameScore& score = scores.frames[k][static_cast<std::size_t>(method)];
    ++summary.frames;
    summary.false_balls += score.false_balls;
    if (!score.found) continue;
    ++summary.found;
    center_px.push_back(score.center_px);
    radius_px.push_back(std::abs(score.radius_px));
    position_mm.push_back(1000 * score.error_C.norm());
    squares_mm2 += position_mm.back() * position_mm.back();
    if (const double bound_mm = 1000 * scores.bounds_m[k]; std::isfinite(bound_mm)) {
      ++bounded;
      bounded_squares_mm2 += position_mm.back() * position_mm.back();
      bound_squares_mm2 += bound_mm * bound_mm;
    }
    nees += score.nees;
    within += score.nees < chi2_95_of_3 ? 1 : 0;
  }
  summary.balls = scores.condition->neighbour == Neighbour::no_ball ? 0 : summary.frames;
  summary.center_median_px = median(center_px);
  summary.radius_median_px = median(radius_px);
  summary.position_median_mm = median(position_mm);
  summary.position_p90_mm = quantile(position_mm, 0.9);
  const double found = summary.found > 0 ? summary.found : std::nan("");
  summary.position_rms_mm = std::sqrt(squares_mm2 / found);
  summary.mean_nees = nees / found;
  summary.within_95 = within / found;
  summary.bound_rms_mm = std::sqrt(bound_squares_mm2 / (bounded > 0 ? bounded : std::nan("")));
  summary.rms_over_bound = std::sqrt(bounded_squares_mm2 / bound_squares_mm2);
  return summary;
}

}  // namespace ballservo::bench
