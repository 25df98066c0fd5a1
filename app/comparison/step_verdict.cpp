#include "app/comparison/step_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ballservo {
namespace {

constexpr double small_part = 0.1, significant = 0.01;

}  // namespace

std::string figure(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size != 0 && size < 5e-5) return "under 0.0001";
  const int decimals = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : size >= 0.01 || size == 0 ? 3 : 4;
  return fmt::format("{:.{}f}", value, decimals);
}

StepComparison compare_steps(const ConditionSummary& summary, const MethodList& methods, std::size_t pair) {
  const MethodPair places = converged_pairs(methods)[pair];
  const PairStatistics& apart = summary.pairs[pair];
  const MethodStatistics &one = summary.methods[places.a], &further = summary.methods[places.b];
  StepComparison result;
  result.short_words = "not told.";
  if (apart.frames == 0) {
    result.words = "not told: no frame in which both found the ball";
    return result;
  }
  if (!std::isfinite(one.position_median_mm)) {
    result.words =
        fmt::format("not told: the centres lie {} px apart (median), but no place in space is known",
                    figure(apart.center_median_px));
    return result;
  }
  const std::string change =
      fmt::format("stepping on moves the ball by {} mm (median) where one step errs by {} mm",
                  figure(apart.position_median_mm), figure(one.position_median_mm));
  const auto test = std::find_if(summary.tests.begin(), summary.tests.end(), [&](const PairedTest& t) {
    return t.pair.a == places.b && t.pair.b == places.a;
  });
  const bool differs = test != summary.tests.end() && test->wilcoxon_p < significant;
  if (apart.position_median_mm < small_part * one.position_median_mm || !differs) {
    result.verdict = StepVerdict::enough;
    result.short_words = "yes.";
    result.words = "yes: " + change;
    if (apart.position_median_mm >= small_part * one.position_median_mm) {
      result.verdict = StepVerdict::undecided;
      result.short_words = "yes, as far as these frames tell.";
      result.words += ", and no test tells which is nearer";
    }
  } else if (test->difference_median_mm < 0) {
    result.verdict = StepVerdict::further_is_better;
    result.short_words = "no.";
    result.words = fmt::format("no: {}, and the converged fit errs by {} mm", change,
                               figure(further.position_median_mm));
  } else {
    result.verdict = StepVerdict::further_is_worse;
    result.short_words = "yes, and more is worse.";
    result.words = fmt::format("yes, and more is worse: {}, and the converged fit errs by {} mm", change,
                               figure(further.position_median_mm));
  }
  return result;
}

StepTotals step_totals(const ComparisonResults& results, std::size_t pair) {
  StepTotals totals;
  std::vector<double> medians_px;
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    const PairStatistics& apart = results.summaries[c].pairs[pair];
    if (apart.frames == 0) continue;
    medians_px.push_back(apart.center_median_px);
    totals.center_max_px = std::max(totals.center_max_px, apart.center_max_px);
    totals.radius_max_px = std::max(totals.radius_max_px, apart.radius_max_px);
    totals.frames += apart.frames;
    totals.breaks += apart.breaks;
    if (4 * apart.breaks >= apart.frames) totals.often_broken.push_back(c);
    const StepVerdict verdict = compare_steps(results.summaries[c], results.methods, pair).verdict;
    totals.told += verdict != StepVerdict::not_told ? 1 : 0;
    if (verdict == StepVerdict::further_is_better) totals.further_is_better.push_back(c);
    totals.undecided += verdict == StepVerdict::undecided ? 1 : 0;
    totals.further_is_worse += verdict == StepVerdict::further_is_worse ? 1 : 0;
  }
  totals.center_median_px = median(medians_px);
  return totals;
}

}  // namespace ballservo
