#include "app/offline/comparison_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/offline/comparison_plots.hpp"
#include "app/offline/step_verdict.hpp"

namespace ballservo {
namespace {

constexpr std::size_t most_rows = 24;

std::string fit_words(const FitMethod& one_step) {
  return one_step.points == MethodPoints::edges ? "The exact fit" : "The paper's fit";
}

// How one step compares with its converged fit, over all conditions.
std::string overall(const ComparisonResults& results, std::size_t pair) {
  const MethodPair places = converged_pairs(results.methods)[pair];
  std::vector<double> medians;
  double largest = 0;
  int enough = 0, better = 0, worse = 0, told = 0;
  for (const ConditionSummary& summary : results.summaries) {
    if (summary.pairs[pair].frames == 0) continue;
    medians.push_back(summary.pairs[pair].center_median_px);
    largest = std::max(largest, summary.pairs[pair].center_max_px);
    const StepVerdict verdict = compare_steps(summary, results.methods, pair).verdict;
    told += verdict != StepVerdict::not_told ? 1 : 0;
    enough += verdict == StepVerdict::enough ? 1 : 0;
    better += verdict == StepVerdict::further_is_better ? 1 : 0;
    worse += verdict == StepVerdict::further_is_worse ? 1 : 0;
  }
  if (medians.empty()) return "";
  const FitMethod& one = *results.methods[places.a];
  std::string text = fit_words(one) + " (" + one.name + "): ";
  if (told > 0) {
    text += fmt::format("one step is enough in {} of {} conditions", enough + worse, told);
    if (worse > 0) text += fmt::format(" (in {} of them converging makes it worse)", worse);
    if (better > 0) text += fmt::format("; in {} the converged fit is nearer to the truth", better);
    if (told < static_cast<int>(results.summaries.size()))
      text += fmt::format("; {} more tell nothing", static_cast<int>(results.summaries.size()) - told);
    text += ". ";
  }
  return text +
         fmt::format(
             "In the median condition the two centres in the picture lie {} px apart, in the worst frame "
             "{} px.",
             figure(quantile(medians, 0.5)), figure(largest));
}

std::string with_interval(double value, const Interval& interval) {
  if (!std::isfinite(interval.low)) return figure(value) + " mm";
  return fmt::format("{} mm (95 % {} to {})", figure(value), figure(interval.low), figure(interval.high));
}

// "The exact fit: yes. ..."
std::string answer_of(const ComparisonResults& results, std::size_t c, std::size_t pair) {
  const MethodPair places = converged_pairs(results.methods)[pair];
  const ConditionSummary& summary = results.summaries[c];
  const MethodStatistics &one = summary.methods[places.a], &converged = summary.methods[places.b];
  const PairStatistics& apart = summary.pairs[pair];
  const StepComparison comparison = compare_steps(summary, results.methods, pair);
  std::string text = fit_words(*results.methods[places.a]) + ": " + comparison.short_words;
  if (comparison.verdict == StepVerdict::not_told) return text;
  return text + fmt::format(
                    " One step errs by {}, the converged fit by {} (medians); they lie {} mm apart, in the "
                    "worst frame {} mm. Found in {} of {} frames.",
                    with_interval(one.position_median_mm, one.position_median_ci95_mm),
                    figure(converged.position_median_mm) + " mm", figure(apart.position_median_mm),
                    figure(apart.position_max_mm), one.found, one.frames);
}

// "enough at all 5 values", "not at 3, 8 (of 4)"
std::string along(const ComparisonResults& results, const Sweep& sweep, std::size_t pair) {
  std::string not_enough, not_told;
  int told = 0;
  const auto add = [](std::string& list, double value) {
    list += (list.empty() ? "" : ", ") + fmt::format("{:g}", value);
  };
  for (const std::size_t c : sweep.conditions) {
    const StepVerdict verdict = compare_steps(results.summaries[c], results.methods, pair).verdict;
    if (verdict == StepVerdict::not_told) add(not_told, results.conditions[c].swept_value);
    if (verdict == StepVerdict::further_is_better) add(not_enough, results.conditions[c].swept_value);
    told += verdict != StepVerdict::not_told ? 1 : 0;
  }
  std::string text = told == 0            ? "not told"
                     : not_enough.empty() ? "enough throughout"
                                          : "not enough at " + not_enough;
  if (told > 0 && !not_told.empty()) text += "; nothing found at " + not_told;
  return text;
}

std::string range_of(const ComparisonResults& results, const Sweep& sweep) {
  return fmt::format("{}: {:g} to {:g}", sweep.label,
                     results.conditions[sweep.conditions.front()].swept_value,
                     results.conditions[sweep.conditions.back()].swept_value);
}

void add_named_conditions(Page& page, const ComparisonResults& results,
                          const std::vector<std::size_t>& pairs) {
  std::vector<std::pair<std::string, std::string>> rows;
  for (std::size_t c = 0; c < results.conditions.size() && rows.size() < most_rows; ++c) {
    if (!results.conditions[c].swept_key.empty()) continue;
    for (const std::size_t pair : pairs)
      rows.emplace_back(pair == pairs.front() ? results.conditions[c].words : "",
                        answer_of(results, c, pair));
  }
  if (rows.empty()) return;
  page.heading("Is one step enough for ...", 3);
  page.key_values(rows);
  page.paragraph(
      "Enough says that stopping after one step is not what errs: stepping on would move the ball by less "
      "than a tenth of the error (medians), or the paired test cannot tell which is nearer to the truth: "
      "yes, "
      "as far as these frames tell. It does not say that the error is small, nor that no single frame "
      "breaks.");
}

void add_sweeps(Page& page, const ComparisonResults& results, const std::vector<std::size_t>& pairs) {
  PageTable table;
  table.heading = {"varied, one at a time"};
  for (const std::size_t pair : pairs)
    table.heading.push_back(fit_words(*results.methods[converged_pairs(results.methods)[pair].a]));
  table.number_columns.assign(table.heading.size(), false);
  for (const Sweep& sweep : sweeps_of(results)) {
    std::vector<std::string> row{range_of(results, sweep)};
    for (const std::size_t pair : pairs) row.push_back(along(results, sweep, pair));
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) return;
  page.heading("... and where one thing is different", 3);
  page.table(table);
}

}  // namespace

std::vector<std::size_t> one_step_pairs(const MethodList& methods) {
  const std::vector<MethodPair> pairs = converged_pairs(methods);
  std::vector<std::size_t> places;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const FitMethod& one = *methods[pairs[k].a];
    if (one.name.find("_one_step") == std::string::npos) continue;
    places.insert(one.points == MethodPoints::edges ? places.begin() : places.end(), k);
  }
  return places;
}

void add_answers(Page& page, const ComparisonResults& results) {
  const std::vector<std::size_t> pairs = one_step_pairs(results.methods);
  for (const std::size_t pair : pairs) {
    const std::string text = overall(results, pair);
    if (!text.empty()) page.note(text);
  }
  if (pairs.empty()) return;
  add_named_conditions(page, results, pairs);
  add_sweeps(page, results, pairs);
}

void add_claims(Page& page, const std::vector<PaperClaim>& claims) {
  if (claims.empty()) return;
  page.heading("The paper's claims");
  PageTable verdicts, measured;
  verdicts.heading = {"the paper says", "verdict"};
  measured.heading = {"the paper says", "measured here", "shown by"};
  verdicts.number_columns = measured.number_columns = {false, false, false};
  for (const PaperClaim& claim : claims) {
    verdicts.rows.push_back({claim.says, claim.verdict});
    measured.rows.push_back({claim.says, claim.measured, claim.shown_by});
  }
  page.table(verdicts);
  page.begin_details("What was measured for each, and what shows it");
  page.table(measured);
  page.end_details();
}

}  // namespace ballservo
