#include "app/comparison/comparison_json.hpp"

namespace ballservo {
namespace {

nlohmann::json pair_results(const PairStatistics& s) {
  return {{"frames", s.frames},
          {"center_median_px", s.center_median_px},
          {"center_max_px", s.center_max_px},
          {"radius_median_px", s.radius_median_px},
          {"radius_max_px", s.radius_max_px},
          {"position_median_mm", s.position_median_mm},
          {"position_max_mm", s.position_max_mm},
          {"breaks", s.breaks},
          {"center_median_ci95_px", {s.center_median_ci95_px.low, s.center_median_ci95_px.high}},
          {"position_median_ci95_mm", {s.position_median_ci95_mm.low, s.position_median_ci95_mm.high}}};
}

}  // namespace

nlohmann::json comparison_json(const ComparisonResults& results) {
  nlohmann::json conditions = nlohmann::json::object(), pairs = nlohmann::json::array(),
                 certificates = nlohmann::json::array();
  const std::vector<MethodPair> all_pairs = converged_pairs(results.methods);
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    const ConditionSummary& summary = results.summaries[c];
    const std::string& name = results.conditions[c].name;
    for (std::size_t m = 0; m < results.methods.size(); ++m) {
      const MethodStatistics& s = summary.methods[m];
      conditions[name][results.methods[m]->name] = {
          {"frames", s.frames},
          {"found", s.found},
          {"found_ci95", {s.found_ci95.low, s.found_ci95.high}},
          {"center_rms_px", s.center_rms_px},
          {"radius_bias_px", s.radius_bias_px},
          {"position_median_mm", s.position_median_mm},
          {"position_median_ci95_mm", {s.position_median_ci95_mm.low, s.position_median_ci95_mm.high}},
          {"position_p90_mm", s.position_p90_mm},
          {"rms_over_bound", s.rms_over_bound}};
    }
    for (std::size_t k = 0; k < all_pairs.size(); ++k) {
      nlohmann::json entry = pair_results(summary.pairs[k]);
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
