#include "app/comparison/resampling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/base/random.hpp"

namespace ballservo {
namespace {

constexpr int resamples = 400;
constexpr std::size_t fewest_values = 5;

}  // namespace

ConfidenceInterval bootstrap(const std::vector<double>& values,
                             const std::function<double(const std::vector<double>&)>& statistic,
                             std::uint64_t seed, std::string_view purpose) {
  if (values.size() < fewest_values) return {not_known, not_known};
  RandomEngine engine = random_stream(seed, purpose);
  std::vector<double> drawn(values.size()), statistics;
  for (int k = 0; k < resamples; ++k) {
    for (double& value : drawn)
      value = values[uniform_index(engine, static_cast<std::uint32_t>(values.size()))];
    statistics.push_back(statistic(drawn));
  }
  return {quantile(statistics, 0.025), quantile(statistics, 0.975)};
}

double wilcoxon_p(const std::vector<double>& differences) {
  std::vector<double> nonzero;
  for (const double d : differences) {
    if (d != 0 && std::isfinite(d)) nonzero.push_back(d);
  }
  const auto n = static_cast<double>(nonzero.size());
  if (n < 6) return 1;
  std::sort(nonzero.begin(), nonzero.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  double positive = 0, ties = 0;
  for (std::size_t i = 0; i < nonzero.size();) {
    std::size_t j = i;
    while (j < nonzero.size() && std::abs(nonzero[j]) == std::abs(nonzero[i])) ++j;
    const double rank = (static_cast<double>(i + j) + 1) / 2, tied = static_cast<double>(j - i);
    for (std::size_t k = i; k < j; ++k) positive += nonzero[k] > 0 ? rank : 0;
    ties += tied * tied * tied - tied;
    i = j;
  }
  const double mean = n * (n + 1) / 4, variance = n * (n + 1) * (2 * n + 1) / 24 - ties / 48;
  const double z = std::max(0.0, std::abs(positive - mean) - 0.5) / std::sqrt(variance);
  return std::erfc(z / std::sqrt(2.0));
}

double mcnemar_p(long only_a, long only_b) {
  const long n = only_a + only_b;
  return n == 0 ? 1 : std::min(1.0, 2 * binomial_cdf(std::min(only_a, only_b), n, 0.5));
}

std::vector<double> holm(const std::vector<double>& p) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if (!std::isnan(p[i])) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return p[a] < p[b]; });
  std::vector<double> adjusted = p;
  double largest = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    largest = std::max(largest, std::min(1.0, p[order[k]] * static_cast<double>(order.size() - k)));
    adjusted[order[k]] = largest;
  }
  return adjusted;
}

}  // namespace ballservo
