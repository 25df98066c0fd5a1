#include "app/comparison/comparison_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "app/comparison/pictures/sweeps.hpp"
#include "app/comparison/step_verdict.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_rows = 24;

std::string fit_words(const FitMethod& one_step) {
  return one_step.points == MethodPoints::edges ? "The exact fit" : "The paper's fit";
}

std::string percent(double part) { return fmt::format("{:.1f} %", 100 * part); }

// "55 of 587 frames (9.4 %)"
std::string break_words(const StepTotals& totals) {
  return fmt::format("{} of {} frames ({})", totals.breaks, totals.frames,
                     percent(static_cast<double>(totals.breaks) / totals.frames));
}

// How one step compares with its converged fit, over all conditions.
std::string overall(const ComparisonResults& results, std::size_t pair) {
  const StepTotals totals = step_totals(results, pair);
  if (totals.frames == 0) return "";
  const FitMethod& one = *results.methods[converged_pairs(results.methods)[pair].a];
  std::string text = fit_words(one) + " (" + one.name + "): ";
  if (totals.told > 0) {
    const int better = static_cast<int>(totals.further_is_better.size());
    text += fmt::format("of {} conditions, one step is enough in {}", results.summaries.size(),
                        totals.told - better - totals.undecided);
    if (totals.further_is_worse > 0)
      text += fmt::format(" (in {} of them converging makes it worse)", totals.further_is_worse);
    if (totals.undecided > 0)
      text += fmt::format("; it is as far as these frames tell in {} more, where no test decides",
                          totals.undecided);
    if (!totals.further_is_better.empty())
      text += "; the converged fit is nearer to the truth at " + in_words(results, totals.further_is_better);
    const int untold = static_cast<int>(results.summaries.size()) - totals.told;
    if (untold > 0) text += fmt::format("; {} tell nothing", untold);
    text += ". ";
  }
  text += "It breaks in " + break_words(totals);
  if (!totals.often_broken.empty())
    text += ", in a quarter or more of them at " + in_words(results, totals.often_broken);
  return text +
         fmt::format(
             ". In the median condition the centres in the picture lie {} px apart; in the worst frames the "
             "centres {} px, the radii {} px.",
             figure(totals.center_median_px), figure(totals.center_max_px), figure(totals.radius_max_px));
}

// What the exact fit does on line before its last step.
std::string second_look(const ComparisonResults& results) {
  std::vector<double> rates;
  for (const ConditionSummary& summary : results.summaries) {
    if (std::isfinite(summary.second_pass_rate)) rates.push_back(summary.second_pass_rate);
  }
  if (rates.empty()) return "";
  return fmt::format(
      "The exact fit's one step is the last of one or two: where the first was longer than a pixel, or the "
      "next would be longer than {:g} px, it measures the edges a second time, from where it has got to, and "
      "steps again. On line as here that happens in {} of the frames (mean over the conditions; the least "
      "{}, the most {}). sphere_one_step is the step after the last measurement, and sphere_converged has "
      "the same points.",
      enough_next_step_px, percent(mean(rates)), percent(*std::min_element(rates.begin(), rates.end())),
      percent(*std::max_element(rates.begin(), rates.end())));
}

std::string with_interval(double value, const ConfidenceInterval& interval) {
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
  return text +
         fmt::format(
             " One step errs by {}, the converged fit by {} mm (medians). They lie {} apart (median), in the "
             "worst frame {} mm; one step breaks in {} of {} frames. Found in {} of {} frames.",
             with_interval(one.position_median_mm, one.position_median_ci95_mm),
             figure(converged.position_median_mm),
             with_interval(apart.position_median_mm, apart.position_median_ci95_mm),
             figure(apart.position_max_mm), apart.breaks, apart.frames, one.found, one.frames);
}

// "enough throughout", "enough; not enough at 3; no test decides at 5, 8"
std::string along(const ComparisonResults& results, const Sweep& sweep, std::size_t pair) {
  std::string not_enough, undecided, not_told;
  bool enough = false;
  const auto add = [](std::string& list, double value) {
    list += (list.empty() ? "" : ", ") + fmt::format("{:g}", value);
  };
  for (const std::size_t c : sweep.conditions) {
    const double value = results.conditions[c].swept_value;
    switch (compare_steps(results.summaries[c], results.methods, pair).verdict) {
      case StepVerdict::not_told:
        add(not_told, value);
        break;
      case StepVerdict::further_is_better:
        add(not_enough, value);
        break;
      case StepVerdict::undecided:
        add(undecided, value);
        break;
      case StepVerdict::enough:
      case StepVerdict::further_is_worse:
        enough = true;
        break;
    }
  }
  const bool throughout = enough && not_enough.empty() && undecided.empty();
  std::string text = throughout ? "enough throughout" : enough ? "enough" : "";
  const auto append = [&](const char* words, const std::string& values) {
    if (!values.empty()) text += (text.empty() ? "" : "; ") + (words + values);
  };
  append("not enough at ", not_enough);
  append("no test decides at ", undecided);
  append("found in no frame at ", not_told);
  return text;
}

std::string range_of(const ComparisonResults& results, const Sweep& sweep) {
  return fmt::format("{}: {:g} to {:g}", sweep.label,
                     results.conditions[sweep.conditions.front()].swept_value,
                     results.conditions[sweep.conditions.back()].swept_value);
}

/// Of each condition that has a name of its own: what is shown, and the answers.
ordered_json named_conditions(const ComparisonResults& results, const std::vector<std::size_t>& pairs) {
  ordered_json rows = ordered_json::array();
  for (std::size_t c = 0; c < results.conditions.size() && rows.size() < most_rows; ++c) {
    if (!results.conditions[c].swept_key.empty()) continue;
    for (const std::size_t pair : pairs)
      rows.push_back({pair == pairs.front() ? results.conditions[c].words : "", answer_of(results, c, pair)});
  }
  return rows;
}

ordered_json along_sweeps(const ComparisonResults& results, const std::vector<std::size_t>& pairs) {
  ordered_json rows = ordered_json::array();
  for (const Sweep& sweep : sweeps_of(results)) {
    ordered_json row{range_of(results, sweep)};
    for (const std::size_t pair : pairs) row.push_back(along(results, sweep, pair));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// How far chance alone moves a median.
std::string repeated_words(const ComparisonResults& results, std::size_t pair) {
  const std::vector<std::size_t> repeated = repeated_setting(results);
  if (repeated.empty()) return "";
  std::string medians;
  const std::size_t m = converged_pairs(results.methods)[pair].a;
  for (const std::size_t c : repeated) {
    const MethodStatistics& s = results.summaries[c].methods[m];
    medians +=
        (medians.empty() ? "" : ", ") + fmt::format("{} ({} frames)", figure(s.position_median_mm), s.frames);
  }
  return fmt::format(
      "One setting stands here {} times, each time on frames of its own: {}. The medians of {} there, {} mm, "
      "differ by chance alone: so far may those of other conditions be off, too, and a verdict with them.",
      repeated.size(), in_words(results, repeated), results.methods[m]->name, medians);
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

nlohmann::ordered_json comparison_answers(const ComparisonResults& results) {
  const std::vector<std::size_t> pairs = one_step_pairs(results.methods);
  ordered_json fits = ordered_json::array(), whole = ordered_json::array();
  for (const std::size_t pair : pairs) {
    fits.push_back(fit_words(*results.methods[converged_pairs(results.methods)[pair].a]));
    const std::string text = overall(results, pair);
    if (!text.empty()) whole.push_back(text);
  }
  return {{"fits", fits},
          {"overall", whole},
          {"second_look", second_look(results)},
          {"conditions", named_conditions(results, pairs)},
          {"sweeps", along_sweeps(results, pairs)},
          {"repeated", pairs.empty() ? "" : repeated_words(results, pairs.front())}};
}

}  // namespace ballservo
