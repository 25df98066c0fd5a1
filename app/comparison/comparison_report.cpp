#include "app/comparison/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/comparison/comparison_answers.hpp"
#include "app/comparison/pictures/sweeps.hpp"
#include "app/comparison/step_verdict.hpp"
#include "app/report/picture.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {
namespace {

using nlohmann::ordered_json;

constexpr const char* the_paper =
    "H. Ghazouani, \"Suivi d'objets basé forme et couleur pour la navigation robotique en temps réel\"";
constexpr std::size_t most_examples = 16, most_curve_points = 500;
constexpr int fewest_breaks_drawn = 5;  // of a rule's curve

ordered_json known(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json conditions_json(const ComparisonResults& results) {
  ordered_json list = ordered_json::array();
  const std::vector<std::size_t> pairs = one_step_pairs(results.methods);
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    const ConditionInfo& info = results.conditions[c];
    ordered_json enough = ordered_json::array();
    for (const std::size_t k : pairs)
      enough.push_back(compare_steps(results.summaries[c], results.methods, k).words);
    list.push_back({{"name", info.name},
                    {"words", info.words},
                    {"swept_value", info.swept_key.empty() ? ordered_json(nullptr) : known(info.swept_value)},
                    {"bound_rms_mm", known(results.summaries[c].bound_rms_mm)},
                    {"enough", enough}});
  }
  return list;
}

ordered_json methods_json(const MethodList& methods) {
  ordered_json list = ordered_json::array();
  for (const FitMethod* method : methods)
    list.push_back({{"name", method->name}, {"minimises", method->minimises}, {"is_peer", method->is_peer}});
  return list;
}

ordered_json sweeps_json(const ComparisonResults& results) {
  ordered_json list = ordered_json::array();
  for (const Sweep& sweep : sweeps_of(results)) {
    ordered_json names = ordered_json::array();
    for (const std::size_t c : sweep.conditions) names.push_back(results.conditions[c].name);
    list.push_back({{"key", sweep.key}, {"label", sweep.label}, {"log", sweep.log}, {"conditions", names}});
  }
  return list;
}

/// Sorted; of very many every second, third ...
ordered_json distribution(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t stride = values.size() / most_curve_points + 1;
  ordered_json list = ordered_json::array();
  for (std::size_t k = values.size() % stride; k < values.size(); k += stride)
    list.push_back(known(values[k]));
  return list;
}

/// How far one step lies from the converged fit: in all frames, and in those of the condition with the
/// largest median.
ordered_json step_pairs_json(const ComparisonResults& results) {
  ordered_json list = ordered_json::array();
  for (const std::size_t k : one_step_pairs(results.methods)) {
    const MethodPair pair = converged_pairs(results.methods)[k];
    std::vector<double> all_px, worst_px;
    std::string worst;
    double largest_median_px = -1;
    for (std::size_t c = 0; c < results.summaries.size(); ++c) {
      const std::vector<double>& px = results.summaries[c].centers_apart_px[k];
      all_px.insert(all_px.end(), px.begin(), px.end());
      if (!(results.summaries[c].pairs[k].center_median_px > largest_median_px)) continue;
      largest_median_px = results.summaries[c].pairs[k].center_median_px;
      worst_px = px;
      worst = results.conditions[c].name;
    }
    list.push_back({{"one_step", results.methods[pair.a]->name},
                    {"converged", results.methods[pair.b]->name},
                    {"apart_px", distribution(all_px)},
                    {"worst_condition", worst},
                    {"worst_apart_px", distribution(worst_px)}});
  }
  return list;
}

std::string percent(double rate) {
  return std::isfinite(rate) ? fmt::format("{:.1f} %", 100 * rate) : std::string("-");
}

// Rules that never ask for a step are all the same: the first stands for them.
bool asks(const CertificateRule& rule) { return std::isfinite(rule.threshold); }

std::string worth_of(const Certificate& c) {
  const CertificateScore& s = c.rules.front().tested;
  if (!asks(c.rules.front()))
    return fmt::format(
        "{}: no rule could be made, for nothing broke where it would have been learnt; {} of the {} frames "
        "tested break, the largest distance (of centres or radii) is {} px.",
        c.one_step, s.breaks, s.frames, figure(c.largest_before_px));
  return fmt::format(
      "{}: one more step where the first rule asks for it is taken in {} of the frames tested and leaves {} "
      "breaks of {}; the largest distance (of centres or radii) falls from {} px to {} px.",
      c.one_step, percent(c.second_step_rate), c.breaks_after, c.breaks_before, figure(c.largest_before_px),
      figure(c.largest_after_px));
}

ordered_json certificates_json(const std::vector<Certificate>& certificates) {
  ordered_json fits = ordered_json::array(), worth = ordered_json::array();
  for (const Certificate& certificate : certificates) {
    ordered_json rules = ordered_json::array();
    for (const CertificateRule& rule : certificate.rules) {
      const CertificateScore& s = rule.tested;
      rules.push_back({{"name", rule.name},
                       {"words", rule.words},
                       {"asks", asks(rule)},
                       {"frames", s.frames},
                       {"breaks", s.breaks},
                       {"caught_rate", known(s.caught_rate())},
                       {"false_alarm_rate", known(s.false_alarm_rate())},
                       {"area", known(s.area)},
                       {"roc_false_alarms", rule.roc_false_alarms},
                       {"roc_caught", rule.roc_caught}});
    }
    fits.push_back({{"one_step", certificate.one_step}, {"rules", rules}});
    if (certificate.rules.front().tested.frames > 0) worth.push_back(worth_of(certificate));
  }
  return {{"tested", !worth.empty()},
          {"fewest", fewest_breaks_drawn},
          {"enough_next_step_px", enough_next_step_px},
          {"fits", fits},
          {"worth", worth}};
}

/// Writes pictures under names of their own and lists them.
class Gallery {
 public:
  Gallery(const WriteFile& write, std::string prefix) : write_(write), prefix_(std::move(prefix)) {}

  void add(const cv::Mat& picture, PictureFormat format, const std::string& caption) {
    const std::string name =
        fmt::format("{}_{}.{}", prefix_, list_.size() + 1, format == PictureFormat::png ? "png" : "jpg");
    write_(name, picture_bytes(picture, format));
    list_.push_back({{"file", name}, {"caption", caption}});
  }
  std::size_t size() const { return list_.size(); }
  ordered_json json() const { return {{"frames", list_}}; }

 private:
  const WriteFile& write_;
  std::string prefix_;
  ordered_json list_ = ordered_json::array();
};

ordered_json examples(const ComparisonResults& results, const ShowFrame& show, const WriteFile& write) {
  Gallery gallery(write, "example");
  for (std::size_t c = 0; c < results.conditions.size() && gallery.size() < most_examples; ++c) {
    const ConditionInfo& info = results.conditions[c];
    if (info.swept_key.empty())
      gallery.add(example_photo(show(c, 0)), PictureFormat::png, info.name + ": " + info.words);
  }
  return gallery.json();
}

ordered_json notable(const ComparisonResults& results, const std::vector<NotableFrame>& frames,
                     const std::string& name, const std::string& unit, const ShowFrame& show,
                     const WriteFile& write) {
  Gallery gallery(write, name);
  for (const NotableFrame& frame : frames) {
    const std::string value = frame.value >= 1e9 ? "not found" : figure(frame.value) + unit;
    gallery.add(outlines_photo(show(frame.condition, frame.index), frame.record, results.methods),
                PictureFormat::jpeg,
                fmt::format("{}, frame {} ({}): {}", results.conditions[frame.condition].name,
                            frame.record.truth.frame, frame.record.truth.source, value));
  }
  return gallery.json();
}

ordered_json photos(const ComparisonResults& results, const ShowFrame& show, const WriteFile& write) {
  if (!show) return ordered_json::object();
  const bool in_space = !results.worst.empty() && results.worst.front().record.truth.p_CB.has_value();
  return {
      {"worst", notable(results, results.worst, "worst", in_space ? " mm off" : " px off", show, write)},
      {"apart", notable(results, results.most_apart, "apart", " px apart (centres or radii)", show, write)},
      {"examples", examples(results, show, write)}};
}

}  // namespace

nlohmann::ordered_json comparison_report(const ComparisonResults& results, const ShowFrame& show,
                                         const WriteFile& write, const ComparisonReportText& text,
                                         const std::vector<PaperClaim>& claims) {
  ordered_json settings = ordered_json::array(), headings = ordered_json::array(),
               claim_list = ordered_json::array();
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    if (!results.peer_words[c].empty())
      settings.push_back(results.conditions[c].name + ": " + results.peer_words[c]);
  }
  for (const std::size_t k : one_step_pairs(results.methods))
    headings.push_back(results.methods[converged_pairs(results.methods)[k].a]->name + ": is it enough?");
  for (const PaperClaim& claim : claims) {
    claim_list.push_back({{"says", claim.says},
                          {"verdict", claim.verdict},
                          {"measured", claim.measured},
                          {"shown_by", claim.shown_by}});
  }
  return {{"page", "comparison"},
          {"subject", text.subject},
          {"rendered", text.rendered},
          {"the_paper", the_paper},
          {"break_px", break_px},
          {"answers", comparison_answers(results)},
          {"claims", claim_list},
          {"conditions", conditions_json(results)},
          {"enough_heading", headings},
          {"methods", methods_json(results.methods)},
          {"peer_settings", settings},
          {"sweeps", sweeps_json(results)},
          {"one_step_pairs", step_pairs_json(results)},
          {"certificates", certificates_json(results.certificates)},
          {"photos", photos(results, show, write)},
          {"setting", text.setting}};
}

}  // namespace ballservo
