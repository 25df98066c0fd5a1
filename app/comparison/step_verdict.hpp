// Is one step enough in a condition? Said in words, by what stepping on would change.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/comparison/comparison.hpp"

namespace ballservo {

/// `undecided`: stepping on moves the ball, and no test tells which place is nearer to the truth.
enum class StepVerdict { enough, undecided, further_is_better, further_is_worse, not_told };

struct StepComparison {
  StepVerdict verdict = StepVerdict::not_told;
  std::string words;        ///< "yes: ..."
  std::string short_words;  ///< "yes."
};

/// One step against the converged fit of the same points (`pair` of the summary's pairs). Enough: the median
/// change of the place is below a tenth of the median error; better or worse: Wilcoxon's test of this one
/// pair says so (p below 0.01).
StepComparison compare_steps(const ConditionSummary& summary, const MethodList& methods, std::size_t pair);

/// A pair over all conditions in which both found the ball in some frame.
struct StepTotals {
  int told = 0;                                ///< conditions that tell whether one step is enough
  std::vector<std::size_t> further_is_better;  ///< conditions, places in the results' list
  int undecided = 0, further_is_worse = 0;
  int frames = 0, breaks = 0;
  std::vector<std::size_t> often_broken;  ///< conditions in which a quarter of the frames break, or more
  double center_median_px = 0;            ///< of the median condition
  double center_max_px = 0, radius_max_px = 0;
};
StepTotals step_totals(const ComparisonResults& results, std::size_t pair);

/// "0.0123", "under 0.0001", "12.3": enough decimals to tell small values from zero; "-" where not finite.
std::string figure(double value);

}  // namespace ballservo
