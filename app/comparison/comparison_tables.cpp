#include "app/comparison/comparison_tables.hpp"

#include <array>

#include "calibration/base/csv_table.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

using nlohmann::json;

/// A row of a table: names of the columns with their values; null, and what is not finite, is an empty cell.
using Row = nlohmann::ordered_json;

std::string heading(std::string text, const Row& row) {
  for (const auto& cell : row.items()) text += ',' + cell.key();
  return text + '\n';
}

std::string csv_row(std::string text, const Row& row) {
  for (const Row& value : row) {
    text += ',';
    if (value.is_number_float()) text += number_text(value.get<double>());
    if (value.is_number_integer()) text += value.dump();
    if (value.is_string()) text += csv_cell(value.get<std::string>());
  }
  return text + '\n';
}

Row both(const ConfidenceInterval& interval) { return {interval.low, interval.high}; }

template <class T>
Row scaled_or_empty(const std::optional<T>& value, double factor = 1) {
  return value ? Row(factor * static_cast<double>(*value)) : Row();
}

Row cells(const MethodStatistics& s) {
  return {{"frames", s.frames},
          {"found", s.found},
          {"failed", s.failed},
          {"center_rms_px", s.center_rms_px},
          {"radius_bias_px", s.radius_bias_px},
          {"radius_rms_px", s.radius_rms_px},
          {"position_median_mm", s.position_median_mm},
          {"position_p90_mm", s.position_p90_mm},
          {"position_rms_mm", s.position_rms_mm},
          {"depth_bias_mm", s.depth_bias_mm},
          {"lateral_bias_mm", s.lateral_bias_mm},
          {"found_low", s.found_ci95.low},
          {"found_high", s.found_ci95.high},
          {"center_median_px", s.center_median_px},
          {"position_median_low_mm", s.position_median_ci95_mm.low},
          {"position_median_high_mm", s.position_median_ci95_mm.high},
          {"depth_spread_mm", s.depth_spread_mm},
          {"depth_rms_mm", s.depth_rms_mm},
          {"lateral_spread_mm", s.lateral_spread_mm},
          {"charged_median_mm", s.charged_median_mm},
          {"bound_rms_mm", s.bound_rms_mm},
          {"rms_over_bound", s.rms_over_bound},
          {"rms_over_bound_low", s.rms_over_bound_ci95.low},
          {"rms_over_bound_high", s.rms_over_bound_ci95.high},
          {"iterations_median", s.iterations_median},
          {"unconverged", s.unconverged},
          {"radius_median_px", s.radius_median_px},
          {"false_balls", s.false_balls},
          {"false_per_1000", 1000 * s.false_balls / s.frames},
          {"nees_mean", s.nees_mean},
          {"inside_95", s.inside_95}};
}

Row cells(const PairStatistics& s) {
  return {{"frames", s.frames},
          {"center_median_px", s.center_median_px},
          {"center_max_px", s.center_max_px},
          {"radius_median_px", s.radius_median_px},
          {"radius_max_px", s.radius_max_px},
          {"position_median_mm", s.position_median_mm},
          {"position_max_mm", s.position_max_mm},
          {"breaks", s.breaks},
          {"center_median_low_px", s.center_median_ci95_px.low},
          {"center_median_high_px", s.center_median_ci95_px.high},
          {"position_median_low_mm", s.position_median_ci95_mm.low},
          {"position_median_high_mm", s.position_median_ci95_mm.high}};
}

Row cells(const PairedTest& t) {
  return {{"frames", t.frames},
          {"difference_median_mm", t.difference_median_mm},
          {"difference_low_mm", t.difference_ci95_mm.low},
          {"difference_high_mm", t.difference_ci95_mm.high},
          {"wilcoxon_p", t.wilcoxon_p},
          {"holm_p", t.holm_p},
          {"only_a", t.only_a},
          {"only_b", t.only_b},
          {"mcnemar_p", t.mcnemar_p}};
}

Row cells(const MethodFit& fit) {
  const Eigen::Vector2d& center_px = fit.outline.center_px;
  Row row{{"cx_px", center_px.x()},
          {"cy_px", center_px.y()},
          {"r_px", fit.outline.radius_px},
          {"x_m", fit.p_C.x()},
          {"y_m", fit.p_C.y()},
          {"z_m", fit.p_C.z()},
          {"iterations", scaled_or_empty(fit.iterations)},
          {"residual_px", scaled_or_empty(fit.residual_px)},
          {"step_px", scaled_or_empty(fit.step_px)},
          {"arc", scaled_or_empty(fit.arc)},
          {"condition_number", scaled_or_empty(fit.condition)},
          {"converged", scaled_or_empty(fit.converged)},
          {"next_step_px", scaled_or_empty(fit.next_step_px)},
          {"others", fit.others}};
  constexpr std::array<std::pair<int, int>, 6> entries{{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
  for (const auto& [i, j] : entries) {
    const std::string name{'s', "xyz"[i], "xyz"[j]};
    row[name + "_m2"] = fit.covariance_m2 ? Row((*fit.covariance_m2)(i, j)) : Row();
  }
  return row;
}

Row cells(const ComparisonRecord& record) {
  const FrameTruth& truth = record.truth;
  const auto& outline = truth.outline;
  const auto& p_CB = truth.p_CB;
  const auto& facts = record.facts;
  return {{"source", truth.source},
          {"frame", truth.frame},
          {"cx_px", outline ? Row(outline->center_px.x()) : Row()},
          {"cy_px", outline ? Row(outline->center_px.y()) : Row()},
          {"r_px", outline ? Row(outline->radius_px) : Row()},
          {"x_m", p_CB ? Row(p_CB->x()) : Row()},
          {"y_m", p_CB ? Row(p_CB->y()) : Row()},
          {"z_m", p_CB ? Row(p_CB->z()) : Row()},
          {"visible_fraction", scaled_or_empty(truth.visible_fraction)},
          {"bound_mm", scaled_or_empty(truth.bound_m, 1000)},
          {"bound_depth_mm", scaled_or_empty(truth.bound_depth_m, 1000)},
          {"votes", facts ? Row(facts->votes) : Row()},
          {"vote_points", facts ? Row(facts->points) : Row()},
          {"vote_quality", facts ? Row(facts->quality) : Row()},
          {"edge_passes", record.passes > 0 ? Row(record.passes) : Row()}};
}

}  // namespace

RowsByFile comparison_headings() {
  return {{"compare.csv", heading("condition,method", cells(MethodStatistics{}))},
          {"pairs.csv", heading("condition,method_a,method_b", cells(PairStatistics{}))},
          {"tests.csv", heading("condition,method_a,method_b", cells(PairedTest{}))},
          {"timing.csv", "condition,method,time_us_median\n"},
          {"fits.csv", heading("condition,source,frame,method,found", cells(MethodFit{}))},
          {"frames.csv", heading("condition", cells(ComparisonRecord{}))}};
}

RowsByFile condition_rows(const ConditionInfo& info, const ConditionSummary& summary,
                          const MethodList& methods) {
  RowsByFile rows;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const std::string place = info.name + ',' + methods[m]->name;
    rows["compare.csv"] += csv_row(place, cells(summary.methods[m]));
    rows["timing.csv"] += place + ',' + number_text(summary.methods[m].time_us_median) + '\n';
  }
  const auto place_of_pair = [&](const MethodPair& pair) {
    return info.name + ',' + methods[pair.a]->name + ',' + methods[pair.b]->name;
  };
  const std::vector<MethodPair> pairs = converged_pairs(methods);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    rows["pairs.csv"] += csv_row(place_of_pair(pairs[k]), cells(summary.pairs[k]));
  for (const PairedTest& test : summary.tests)
    rows["tests.csv"] += csv_row(place_of_pair(test.pair), cells(test));
  return rows;
}

RowsByFile frame_rows(const ConditionInfo& info, const ComparisonRecord& record, const MethodList& methods) {
  const FrameTruth& truth = record.truth;
  RowsByFile rows{{"frames.csv", csv_row(info.name, cells(record))}};
  const std::string place =
      info.name + ',' + csv_cell(truth.source) + ',' + std::to_string(truth.frame) + ',';
  static const std::string no_fit = std::string(cells(MethodFit{}).size(), ',') + '\n';
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const auto& fit = record.fits[m];
    const std::string found = place + methods[m]->name + (fit && at_the_ball(*fit, truth) ? ",1" : ",0");
    rows["fits.csv"] += fit ? csv_row(found, cells(*fit)) : found + no_fit;
  }
  return rows;
}

json comparison_json(const ComparisonResults& results) {
  json conditions = json::object(), pairs = json::array(), certificates = json::array();
  const std::vector<MethodPair> all_pairs = converged_pairs(results.methods);
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    const ConditionSummary& summary = results.summaries[c];
    const std::string& name = results.conditions[c].name;
    for (std::size_t m = 0; m < results.methods.size(); ++m) {
      const MethodStatistics& s = summary.methods[m];
      json& entry = conditions[name][results.methods[m]->name];
      const Row row = cells(s);
      for (const char* key : {"frames", "found", "center_rms_px", "radius_bias_px", "position_median_mm",
                              "position_p90_mm", "rms_over_bound"})
        entry[key] = row[key];
      entry["found_ci95"] = both(s.found_ci95);
      entry["position_median_ci95_mm"] = both(s.position_median_ci95_mm);
    }
    for (std::size_t k = 0; k < all_pairs.size(); ++k) {
      const PairStatistics& s = summary.pairs[k];
      const Row row = cells(s);
      json entry;
      for (const char* key : {"frames", "center_median_px", "center_max_px", "radius_median_px",
                              "radius_max_px", "position_median_mm", "position_max_mm", "breaks"})
        entry[key] = row[key];
      entry["center_median_ci95_px"] = both(s.center_median_ci95_px);
      entry["position_median_ci95_mm"] = both(s.position_median_ci95_mm);
      entry["condition"] = name;
      entry["method_a"] = results.methods[all_pairs[k].a]->name;
      entry["method_b"] = results.methods[all_pairs[k].b]->name;
      pairs.push_back(entry);
    }
  }
  for (const Certificate& c : results.certificates) {
    for (const CertificateRule& rule : c.rules) {
      certificates.push_back({{"one_step", c.one_step},
                              {"rule", rule.name},
                              {"words", rule.words},
                              {"tested_frames", rule.tested.frames},
                              {"breaks", rule.tested.breaks},
                              {"caught_rate", rule.tested.caught_rate()},
                              {"false_alarm_rate", rule.tested.false_alarm_rate()},
                              {"roc_area", rule.tested.area}});
    }
  }
  return {{"conditions", conditions}, {"pairs", pairs}, {"certificates", certificates}};
}

}  // namespace ballservo
