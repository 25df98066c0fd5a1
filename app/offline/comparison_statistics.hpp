// The figures of a comparison, and the files that hold them.
#pragma once

#include <string>
#include <vector>

#include "app/offline/comparison.hpp"

namespace ballservo {

/// Quantile (0 to 1) by linear interpolation between order statistics; NaN for no values.
double quantile(std::vector<double> values, double fraction);

/// One row of compare.csv. Errors are over the frames in which the method found the ball, NaN where there is
/// none.
struct MethodStatistics {
  int frames = 0;
  int found = 0;   ///< frames with an answer at the ball, see at_the_ball
  int failed = 0;  ///< the others: no answer, or one elsewhere
  double center_rms_px = 0;
  double radius_bias_px = 0, radius_rms_px = 0;
  double position_median_mm = 0, position_p90_mm = 0, position_rms_mm = 0;
  double depth_bias_mm = 0;    ///< mean error of Z
  double lateral_bias_mm = 0;  ///< mean error across the axis, positive away from the axis
  double time_us_median = 0;
};

MethodStatistics method_statistics(const ConditionResult& condition, std::size_t method);

/// Two methods that share points and weights.
struct MethodPair {
  FitMethod a, b;
};
/// The pairs of one step and converged fit among the comparison's methods.
std::vector<MethodPair> one_step_pairs(const std::vector<FitMethod>& methods);

/// One row of pairs.csv: how far two methods' answers lie apart, over the frames in which both found the
/// ball.
struct PairStatistics {
  int frames = 0;
  double center_median_px = 0, center_max_px = 0, radius_median_px = 0, radius_max_px = 0;
  double position_median_mm = 0, position_max_mm = 0;
};

/// The differences themselves, frame by frame.
struct PairDifferences {
  std::vector<double> center_px, radius_px, position_mm;

  void add(const PairDifferences& other);
  PairStatistics statistics() const;
};
PairDifferences pair_differences(const Comparison& comparison, const ConditionResult& condition,
                                 const MethodPair& pair);

std::string compare_csv(const Comparison& comparison);
std::string fits_csv(const Comparison& comparison);
std::string pairs_csv(const Comparison& comparison);
std::string timing_csv(const Comparison& comparison);

}  // namespace ballservo
