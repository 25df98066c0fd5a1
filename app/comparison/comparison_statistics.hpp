// The figures of a comparison, condition by condition: a frame's record is looked at once and let go.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/comparison/estimators/methods.hpp"
#include "app/comparison/frame_record.hpp"
#include "app/comparison/resampling.hpp"

namespace ballservo {

/// One row of compare.csv. Errors are over the frames in which the method found the ball, NaN where there is
/// none or no truth. What a method does not find is in `failed` and in `charged_median_mm`, never dropped.
struct MethodStatistics {
  int frames = 0;
  int found = 0;   ///< frames with an answer at the ball, see at_the_ball
  int failed = 0;  ///< of the other frames those that have a ball: no answer, or one elsewhere
  double center_rms_px, radius_bias_px, radius_rms_px;
  double position_median_mm, position_p90_mm, position_rms_mm;
  double depth_bias_mm;    ///< mean error of Z
  double lateral_bias_mm;  ///< mean error across the axis, positive away from the axis
  double time_us_median;

  ConfidenceInterval found_ci95, position_median_ci95_mm;
  double center_median_px;
  double depth_spread_mm, lateral_spread_mm;  ///< standard deviations about the bias; lateral: all of x, y
  double depth_rms_mm;
  /// The median over all frames, a failure counted as an error without bound: infinite where most fail.
  double charged_median_mm;
  double bound_rms_mm, rms_over_bound;  ///< of the frames found that have a bound
  ConfidenceInterval rms_over_bound_ci95;
  double iterations_median, unconverged;  ///< of the fits that say so; share that did not converge
  double radius_median_px;                ///< of the absolute errors
  double false_balls;                     ///< answers elsewhere, others of a detector; NaN without a truth
  /// Of the squared Mahalanobis distance of the position, where a method states its covariance: 3 where that
  /// is true; and the share of positions inside the 95 % ellipsoid.
  double nees_mean, inside_95;
};

/// Two methods that are held against each other frame by frame, over the frames in which both found the ball.
struct MethodPair {
  std::size_t a, b;  ///< places in the list of methods
};
/// The pairs among the methods: one step, more steps and robust fits, each with the converged fit of the same
/// points.
std::vector<MethodPair> converged_pairs(const MethodList& methods);

/// One row of pairs.csv.
struct PairStatistics {
  int frames = 0;
  int breaks = 0;  ///< frames in which they lie more than break_px apart
  double center_median_px, center_max_px, radius_median_px, radius_max_px;
  double position_median_mm, position_max_mm;
  ConfidenceInterval center_median_ci95_px, position_median_ci95_mm;  ///< bootstrap
};

/// One row of tests.csv: is one method nearer to the truth than the other on the same frames?
struct PairedTest {
  MethodPair pair;
  int frames = 0;                         ///< in which both found the ball
  double difference_median_mm;            ///< of |error a| - |error b|: negative where a is the better
  ConfidenceInterval difference_ci95_mm;  ///< bootstrap
  double wilcoxon_p, holm_p;              ///< of the differences; adjusted for the condition's tests
  int only_a = 0, only_b = 0;             ///< frames in which only one found the ball
  double mcnemar_p;
};

/// All that is kept of a condition.
struct ConditionSummary {
  std::vector<MethodStatistics> methods;
  std::vector<PairStatistics> pairs;  ///< in the order of converged_pairs
  /// Of the same, the distances between the centres (px), thinned to at most 400 frames.
  std::vector<std::vector<double>> centers_apart_px;
  std::vector<PairedTest> tests;
};

/// Adds up the frames of one condition, of which it keeps a few numbers each.
class ConditionStatistics {
 public:
  /// `seed` draws the bootstrap's samples.
  ConditionStatistics(std::string name, const MethodList& methods, std::uint64_t seed);
  ~ConditionStatistics();

  void add(const ComparisonRecord& frame);
  ConditionSummary summary() const;

 private:
  class Errors;
  class Differences;
  class Duel;
  std::string purpose_of(const MethodPair& pair) const;

  std::string name_;
  MethodList methods_;
  std::uint64_t seed_;
  std::vector<MethodPair> pairs_;
  std::vector<Errors> errors_;
  std::vector<Differences> differences_;
  std::vector<Duel> duels_;
};

}  // namespace ballservo
