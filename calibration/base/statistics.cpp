#include "calibration/base/statistics.hpp"

#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>

namespace ballservo {

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? not_known : sum / static_cast<double>(values.size());
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? not_known : std::sqrt(sum / static_cast<double>(values.size()));
}

double standard_deviation(const std::vector<double>& values) {
  if (values.size() < 2) return not_known;
  const double middle = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return not_known;
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(values.begin(), at, values.end());
  const double part = place - static_cast<double>(below);
  if (part == 0) return *at;
  const double next = *std::min_element(at + 1, values.end());
  return next == *at ? next : *at + part * (next - *at);  // infinite values among them stay infinite
}

double median(const std::vector<double>& values) { return quantile(values, 0.5); }

ConfidenceInterval clopper_pearson_ci95(long successes, long trials) {
  if (trials <= 0) return {not_known, not_known};
  const auto k = static_cast<double>(successes), n = static_cast<double>(trials);
  return {successes <= 0 ? 0 : boost::math::ibeta_inv(k, n - k + 1, 0.025),
          successes >= trials ? 1 : boost::math::ibeta_inv(k + 1, n - k, 0.975)};
}

ConfidenceInterval wilson_ci95(long successes, long trials) {
  if (trials <= 0) return {not_known, not_known};
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n, z2 = z_95 * z_95;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = z_95 / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

double binomial_cdf(long k, long n, double p) {
  if (k < 0) return 0;
  if (k >= n) return 1;
  return boost::math::ibetac(static_cast<double>(k + 1), static_cast<double>(n - k), p);
}

ConfidenceInterval median_ci95(std::vector<double> values) {
  if (values.empty()) return {not_known, not_known};
  std::sort(values.begin(), values.end());
  const long n = static_cast<long>(values.size());
  long k = -1;  // the values k places from either end hold the median between them
  while (binomial_cdf(k + 1, n, 0.5) <= 0.025) ++k;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  if (k < 0) return {-infinity, infinity};
  return {values[static_cast<std::size_t>(k)], values[static_cast<std::size_t>(n - 1 - k)]};
}

void MatchedCounts::add(bool first, bool second) {
  ++(first ? (second ? both : only_first) : (second ? only_second : neither));
}

double MatchedCounts::difference() const {
  return pairs() == 0 ? not_known
                      : static_cast<double>(only_first - only_second) / static_cast<double>(pairs());
}

ConfidenceInterval matched_difference_ci95(const MatchedCounts& counts) {
  if (counts.pairs() == 0) return {not_known, not_known};
  const double n = static_cast<double>(counts.pairs()) + 2;
  const double b = static_cast<double>(counts.only_first) + 0.5;
  const double c = static_cast<double>(counts.only_second) + 0.5;
  const double middle = (b - c) / n;
  const double half = z_95 * std::sqrt(b + c - (b - c) * (b - c) / n) / n;
  return {std::max(-1.0, middle - half), std::min(1.0, middle + half)};
}

}  // namespace ballservo
