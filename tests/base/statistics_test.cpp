#include "calibration/base/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

TEST(Quantile, Interpolates) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({4, 1, 2, 3}, 0.5), 2.5);
  EXPECT_EQ(quantile({0, 10}, 0.9), 9);
  EXPECT_EQ(quantile({7}, 0.1), 7);
  EXPECT_EQ(quantile({5, 1, 4, 2, 3}, 1), 5);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

// Failures count as errors without bound: the median is infinite where most are, and only there.
TEST(Quantile, HasAPlaceForInfinity) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(median({1, 2, infinity}), 2);
  EXPECT_EQ(median({1, infinity}), infinity);
  EXPECT_EQ(median({1, infinity, infinity}), infinity);
  EXPECT_EQ(median({1, infinity, infinity, infinity}), infinity);
}

TEST(UpperMedian, IsOneOfTheValues) {
  EXPECT_EQ(upper_median(std::vector<double>{3, 1, 2}), 2);
  EXPECT_EQ(upper_median(std::vector<float>{4, 1, 2, 3}), 3);
}

TEST(Moments, AreThoseOfTheTextbook) {
  EXPECT_EQ(mean({1, 2, 6}), 3);
  EXPECT_EQ(root_mean_square({1, -7, 5, 5}), 5);
  EXPECT_EQ(standard_deviation({2, 4, 4, 4, 5, 5, 7, 9}), std::sqrt(32.0 / 7));
  EXPECT_TRUE(std::isnan(mean({})));
  EXPECT_TRUE(std::isnan(root_mean_square({})));
  EXPECT_TRUE(std::isnan(standard_deviation({1})));
}

TEST(Wilson, IsThatOfTheTextbook) {
  const ConfidenceInterval half = wilson_ci95(5, 10);  // 0.2366 to 0.7634
  EXPECT_NEAR(half.low, 0.2366, 1e-4);
  EXPECT_NEAR(half.high, 0.7634, 1e-4);
  EXPECT_NEAR(wilson_ci95(20, 20).low, 0.8389, 1e-4);
  EXPECT_EQ(wilson_ci95(20, 20).high, 1);
  EXPECT_TRUE(std::isnan(wilson_ci95(0, 0).low));
}

/// Sum of binomial probabilities, term by term.
double summed_cdf(long k, long n, double p) {
  double sum = 0;
  for (long i = 0; i <= k; ++i) {
    sum += std::exp(std::lgamma(n + 1) - std::lgamma(i + 1) - std::lgamma(n - i + 1) + i * std::log(p) +
                    (n - i) * std::log1p(-p));
  }
  return sum;
}

TEST(Intervals, TheBinomialDistributionIsItsSum) {
  for (const long n : {1L, 7L, 60L, 3000L}) {
    for (const double p : {1e-4, 0.03, 0.5, 0.9}) {
      for (const long k : {0L, 1L, n / 3, n - 1}) {
        if (k >= n) continue;
        EXPECT_NEAR(binomial_cdf(k, n, p), summed_cdf(k, n, p), 1e-10) << k << " of " << n << " at " << p;
      }
    }
  }
}

TEST(Intervals, ProportionsHaveTheirClosedForms) {
  // No success, or nothing but successes: (alpha / 2)^(1 / n).
  EXPECT_NEAR(clopper_pearson_ci95(0, 3000).high, 1 - std::pow(0.025, 1.0 / 3000), 1e-12);
  EXPECT_EQ(clopper_pearson_ci95(0, 3000).low, 0);
  EXPECT_NEAR(clopper_pearson_ci95(17, 17).low, std::pow(0.025, 1.0 / 17), 1e-12);
  EXPECT_TRUE(std::isnan(clopper_pearson_ci95(0, 0).low));
}

TEST(Intervals, HoldTheTruthAsOftenAsTheySay) {
  RandomEngine engine = random_stream(1, "intervals");
  int proportion = 0, difference = 0, median = 0;
  constexpr int experiments = 2000, n = 80;
  for (int k = 0; k < experiments; ++k) {
    long successes = 0;
    MatchedCounts counts;
    std::vector<double> values;
    for (int i = 0; i < n; ++i) {
      const double u = uniform01(engine);
      const bool a = u < 0.9, b = uniform01(engine) < (a ? 0.9 : 0.3);  // P(b) = 0.84
      successes += a ? 1 : 0;
      counts.add(a, b);
      values.push_back(std::exp(standard_normal(engine)));
    }
    const auto holds = [](const ConfidenceInterval& interval, double truth) {
      return interval.low <= truth && truth <= interval.high ? 1 : 0;
    };
    proportion += holds(clopper_pearson_ci95(successes, n), 0.9);
    difference += holds(matched_difference_ci95(counts), 0.06);
    median += holds(median_ci95(values), 1.0);
  }
  EXPECT_GE(proportion, 0.95 * experiments);  // exact intervals are too wide, never too narrow
  EXPECT_GE(median, 0.94 * experiments);
  EXPECT_LE(median, 0.98 * experiments);
  EXPECT_GE(difference, 0.93 * experiments);
  EXPECT_LE(difference, 0.98 * experiments);
}

}  // namespace
}  // namespace ballservo
