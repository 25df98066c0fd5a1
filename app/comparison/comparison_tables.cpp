#include "app/comparison/comparison_tables.hpp"

#include <array>

#include "calibration/base/csv_table.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {
namespace {

using nlohmann::json;

/// Null, and what is not finite, is an empty cell.
using Row = Figures;

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

template <class T>
Row scaled_or_empty(const std::optional<T>& value, double factor = 1) {
  return value ? Row(factor * static_cast<double>(*value)) : Row();
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
  // A condition without frames has the columns of all.
  const ConditionSummary summary =
      ConditionStatistics("", {find_fit_method("paper_one_step"), find_fit_method("paper_converged")}, 0)
          .summary();
  return {{"compare.csv", heading("condition,method", summary.methods.front())},
          {"pairs.csv", heading("condition,method_a,method_b", summary.pairs.front())},
          {"tests.csv", heading("condition,method_a,method_b", summary.tests.front())},
          {"timing.csv", "condition,method,time_us_median\n"},
          {"fits.csv", heading("condition,source,frame,method,found", cells(MethodFit{}))},
          {"frames.csv", heading("condition", cells(ComparisonRecord{}))}};
}

RowsByFile condition_rows(const ConditionInfo& info, const ConditionSummary& summary,
                          const MethodList& methods) {
  RowsByFile rows;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const std::string place = info.name + ',' + methods[m]->name;
    rows["compare.csv"] += csv_row(place, summary.methods[m]);
    rows["timing.csv"] += place + ',' + number_text(summary.times_us[m]) + '\n';
  }
  const auto add = [&](const std::string& file, const std::vector<MethodPair>& pairs,
                       const std::vector<Figures>& figures) {
    for (std::size_t k = 0; k < pairs.size(); ++k)
      rows[file] +=
          csv_row(info.name + ',' + methods[pairs[k].a]->name + ',' + methods[pairs[k].b]->name, figures[k]);
  };
  add("pairs.csv", converged_pairs(methods), summary.pairs);
  add("tests.csv", tested_pairs(methods), summary.tests);
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
      const Figures& figures = summary.methods[m];
      json& entry = conditions[name][results.methods[m]->name];
      for (const char* key : {"frames", "found", "center_rms_px", "radius_bias_px", "position_median_mm",
                              "position_p90_mm", "rms_over_bound"})
        entry[key] = figures[key];
      entry["found_ci95"] = {figures["found_low"], figures["found_high"]};
      entry["position_median_ci95_mm"] = {figures["position_median_low_mm"],
                                          figures["position_median_high_mm"]};
    }
    for (std::size_t k = 0; k < all_pairs.size(); ++k) {
      const Figures& figures = summary.pairs[k];
      json entry = {
          {"condition", name},
          {"method_a", results.methods[all_pairs[k].a]->name},
          {"method_b", results.methods[all_pairs[k].b]->name},
          {"center_median_ci95_px", {figures["center_median_low_px"], figures["center_median_high_px"]}},
          {"position_median_ci95_mm",
           {figures["position_median_low_mm"], figures["position_median_high_mm"]}}};
      for (const char* key : {"frames", "center_median_px", "center_max_px", "radius_median_px",
                              "radius_max_px", "position_median_mm", "position_max_mm", "breaks"})
        entry[key] = figures[key];
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
