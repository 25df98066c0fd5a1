// Bootstrap intervals, and tests of paired differences.
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "calibration/base/statistics.hpp"

namespace ballservo {

/// Percentile bootstrap (Efron 1979) of a statistic over values, 400 resamples drawn from (seed, purpose).
/// Of fewer than 5 values, nothing.
ConfidenceInterval bootstrap(const std::vector<double>& values,
                             const std::function<double(const std::vector<double>&)>& statistic,
                             std::uint64_t seed, std::string_view purpose);

/// Two-sided p of Wilcoxon's signed-rank test (1945) that paired differences are symmetric about 0: normal
/// approximation with corrections for ties and continuity. 1 where fewer than 6 differ.
double wilcoxon_p(const std::vector<double>& differences);

/// Two-sided exact p of McNemar's test (1947): among frames in which only one of two methods finds the ball,
/// is each as likely? 1 where there are none.
double mcnemar_p(long only_a, long only_b);

/// Holm's step-down adjustment (1979) of p values for their number; NaN stay and do not count.
std::vector<double> holm(const std::vector<double>& p);

}  // namespace ballservo
