// Confidence intervals of what many trials show.
#pragma once

#include <vector>

#include "app/report/interval.hpp"

namespace ballservo {

/// Of a probability of which `successes` in `trials` were seen: Clopper and Pearson's exact interval
/// (Biometrika 26, 1934), so 0 in 3000 bounds it at 0.12 % (two-sided). NaN for no trials.
Interval proportion_ci95(long successes, long trials);

/// The probability (0 to 1) of at most `k` successes in `n` trials of probability `p`.
double binomial_cdf(long k, long n, double p);

/// Two treatments of the same cases: how often only one of them succeeded.
struct MatchedCounts {
  long both = 0, only_first = 0, only_second = 0, neither = 0;
  long pairs() const { return both + only_first + only_second + neither; }
  /// Share of successes of the first less that of the second; NaN for no pairs.
  double difference() const;
};

/// Of that difference: Wald's interval after half a case is added to each of the four counts (Agresti and
/// Min, Statistics in Medicine 24, 2005), which also is honest where the two never differ.
Interval matched_difference_ci95(const MatchedCounts& counts);

/// Of the median of what `values` are drawn from: between order statistics, whatever the distribution (the
/// sign test's interval); at least 95 %. Infinite ends where there are fewer than 6 values, NaN for none.
Interval median_ci95(std::vector<double> values);

}  // namespace ballservo
