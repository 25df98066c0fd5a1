#include "app/sweep/intervals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// I_x(a, b) by Lentz's evaluation of the continued fraction DLMF 8.17.22, for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto nonzero = [](double value) { return std::abs(value) < tiny ? tiny : value; };
  double C = 1, D = 1 / nonzero(1 - (a + b) * x / (a + 1)), f = D;
  for (int m = 1; m <= 10000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    for (const double d : {even, odd}) {
      D = 1 / nonzero(1 + d * D);
      C = nonzero(1 + d / C);
      f *= C * D;
    }
    if (std::abs(C * D - 1) < 1e-15) break;
  }
  return std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) +
                  b * std::log1p(-x)) *
         f / a;
}

double regularised_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  return x < (a + 1) / (a + b + 2) ? beta_fraction(a, b, x) : 1 - beta_fraction(b, a, 1 - x);
}

/// Where a function that falls from above `level` to below it over [0, 1] crosses it.
template <class Falling>
double crossing(const Falling& falling, double level) {
  double low = 0, high = 1;
  for (int k = 0; k < 100; ++k) {
    const double middle = (low + high) / 2;
    (falling(middle) > level ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

double binomial_cdf(long k, long n, double p) {
  if (k < 0) return 0;
  if (k >= n) return 1;
  return regularised_beta(static_cast<double>(n - k), static_cast<double>(k + 1), 1 - p);
}

Interval proportion_ci95(long successes, long trials) {
  if (trials <= 0) return {nan, nan};
  const auto at_most = [trials](long k) { return [=](double p) { return binomial_cdf(k, trials, p); }; };
  return {successes <= 0 ? 0 : crossing(at_most(successes - 1), 0.975),
          successes >= trials ? 1 : crossing(at_most(successes), 0.025)};
}

double MatchedCounts::difference() const {
  return pairs() == 0 ? nan : static_cast<double>(only_first - only_second) / static_cast<double>(pairs());
}

Interval matched_difference_ci95(const MatchedCounts& counts) {
  if (counts.pairs() == 0) return {nan, nan};
  constexpr double z = 1.959963984540054;
  const double n = static_cast<double>(counts.pairs()) + 2;
  const double b = static_cast<double>(counts.only_first) + 0.5;
  const double c = static_cast<double>(counts.only_second) + 0.5;
  const double middle = (b - c) / n;
  const double half = z * std::sqrt(b + c - (b - c) * (b - c) / n) / n;
  return {std::max(-1.0, middle - half), std::min(1.0, middle + half)};
}

Interval median_ci95(std::vector<double> values) {
  if (values.empty()) return {nan, nan};
  std::sort(values.begin(), values.end());
  const long n = static_cast<long>(values.size());
  long k = -1;  // the values k places from either end hold the median between them
  while (binomial_cdf(k + 1, n, 0.5) <= 0.025) ++k;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (k < 0) return {-infinity, infinity};
  return {values[static_cast<std::size_t>(k)], values[static_cast<std::size_t>(n - 1 - k)]};
}

}  // namespace ballservo
