// What each method says of the same frames, and how right it is.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/bench/accuracy_condition.hpp"

namespace ballservo::bench {

/// Ours and the peers, in the order of the tables.
enum class AccuracyMethod { sphere, paper, hough_gradient, hsv_contour };
inline constexpr std::array<AccuracyMethod, 4> all_accuracy_methods{
    AccuracyMethod::sphere, AccuracyMethod::paper, AccuracyMethod::hough_gradient,
    AccuracyMethod::hsv_contour};
const char* accuracy_method_name(AccuracyMethod method);  ///< "sphere"

/// One method in one frame. Found: a candidate's centre lies within 0.2 r of the true one and its radius is
/// right to 20 %; the nearest such candidate counts, for ours and the peers alike, all others are false.
struct FrameScore {
  bool found = false;
  int false_balls = 0;
  double center_px = 0, radius_px = 0;  ///< errors; the radius's with its sign
  Eigen::Vector3d error_C{0, 0, 0};     ///< of the position, m
  double nees = 0;                      ///< squared Mahalanobis distance of the position (sphere, paper)
  double sigma_depth_m = 0;             ///< what the covariance says of the distance
  double quality = 0, residual_px = 0, blur_px = 0, arc = 0;
};

/// All frames of a condition: scores[frame][method].
struct ConditionScores {
  const AccuracyCondition* condition = nullptr;
  std::vector<std::array<FrameScore, all_accuracy_methods.size()>> frames;
  /// The least sigma (m) of the position that any unbiased estimator can have in each frame
  /// (position_bound.hpp, all its nuisances unknown); NaN without a ball, and where the picture does not
  /// determine it.
  std::vector<double> bounds_m;
  cv::Mat example;                                ///< the first frame around the ball, with what was found
  std::vector<std::pair<int, cv::Mat>> failures;  ///< the first frames that ours missed or saw falsely
};

/// `on_frame` is called after each.
ConditionScores score_condition(const AccuracyCondition& condition, std::uint64_t seed, int frames,
                                const std::function<void()>& on_frame);

/// One row of the table.
struct MethodSummary {
  int frames = 0, balls = 0, found = 0, false_balls = 0;
  double center_median_px = 0, radius_median_px = 0;
  double position_median_mm = 0, position_p90_mm = 0, position_rms_mm = 0;
  double mean_nees = 0;       ///< 3 degrees of freedom: about 3 where the covariance is true
  double within_95 = 0;       ///< fraction of the frames with a NEES below 7.81
  double bound_rms_mm = 0;    ///< of the frames in which the ball was found
  double rms_over_bound = 0;  ///< 1 for an efficient estimator
};
MethodSummary summarize(const ConditionScores& scores, AccuracyMethod method);

}  // namespace ballservo::bench
