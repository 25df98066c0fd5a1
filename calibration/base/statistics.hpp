// Statistics of samples, and 95 % confidence intervals that lean on no distribution of theirs.
#pragma once

#include <algorithm>
#include <limits>
#include <vector>

namespace ballservo {

inline constexpr double not_known = std::numeric_limits<double>::quiet_NaN();

/// NaN for no values, as are all figures below unless they say otherwise.
double mean(const std::vector<double>& values);
double root_mean_square(const std::vector<double>& values);
/// With n - 1 in the denominator; NaN for fewer than 2 values.
double standard_deviation(const std::vector<double>& values);

/// Quantile (`fraction` from 0 to 1) by linear interpolation between order statistics.
double quantile(std::vector<double> values, double fraction);
/// The quantile at one half.
double median(const std::vector<double>& values);

/// The median without interpolation: of an even number of values, the larger of the two in the middle.
/// Reorders `values`, which must not be empty; needs no memory of its own.
template <class Values>
auto upper_median(Values&& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The standard deviation of normal errors is this many times the median of their absolute values.
constexpr double sigma_of_median = 1.4826;
/// 95 % of normal errors are no larger than this many standard deviations.
constexpr double z_95 = 1.959963984540054;

/// Of 95 %: it holds the true value in 95 of 100 such experiments.
struct ConfidenceInterval {
  double low, high;
};

/// Of a probability of which `successes` in `trials` were seen: Clopper and Pearson's exact interval
/// (Biometrika 26, 1934), so 0 in 3000 bounds it at 0.12 % (two-sided).
ConfidenceInterval clopper_pearson_ci95(long successes, long trials);

/// The same by Wilson's score (JASA 22, 1927): narrower, and right on average instead of always.
ConfidenceInterval wilson_ci95(long successes, long trials);

/// The probability (0 to 1) of at most `k` successes in `n` trials of probability `p`.
double binomial_cdf(long k, long n, double p);

/// Of the median of what `values` are drawn from: between order statistics (the sign test's interval); at
/// least 95 %. Infinite ends where there are fewer than 6 values.
ConfidenceInterval median_ci95(std::vector<double> values);

/// Two treatments of the same cases: how often only one of them succeeded.
struct MatchedCounts {
  long both = 0, only_first = 0, only_second = 0, neither = 0;
  long pairs() const { return both + only_first + only_second + neither; }
  void add(bool first, bool second);
  /// Share of successes of the first less that of the second.
  double difference() const;
};

/// Of that difference: Wald's interval after half a case is added to each of the four counts (Agresti and
/// Min, Statistics in Medicine 24, 2005), which also is honest where the two never differ.
ConfidenceInterval matched_difference_ci95(const MatchedCounts& counts);

}  // namespace ballservo
