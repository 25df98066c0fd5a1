#include "app/comparison/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/report/picture.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_examples = 16, most_curve_points = 500;

/// Sorted; of very many every second, third ...
ordered_json sorted_sample(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t stride = values.size() / most_curve_points + 1;
  ordered_json list = ordered_json::array();
  for (std::size_t k = values.size() % stride; k < values.size(); k += stride) list.push_back(values[k]);
  return list;
}

/// How far one step lies from the converged fit, the exact fit's first: in all frames, and in those of the
/// condition with the largest median.
ordered_json step_pairs(const ComparisonResults& results) {
  std::vector<ordered_json> list;
  const std::vector<MethodPair> pairs = converged_pairs(results.methods);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const FitMethod& one = *results.methods[pairs[k].a];
    if (one.name.find("_one_step") == std::string::npos) continue;
    std::vector<double> all_px, worst_px;
    std::string worst;
    double largest_median_px = -1;
    for (std::size_t c = 0; c < results.summaries.size(); ++c) {
      const std::vector<double>& px = results.summaries[c].centers_apart_px[k];
      all_px.insert(all_px.end(), px.begin(), px.end());
      const double median_px = results.summaries[c].pairs[k]["center_median_px"];
      if (!(median_px > largest_median_px)) continue;
      largest_median_px = median_px;
      worst_px = px;
      worst = results.conditions[c].name;
    }
    ordered_json entry = {{"one_step", one.name},
                          {"converged", results.methods[pairs[k].b]->name},
                          {"apart_px", sorted_sample(all_px)},
                          {"worst_condition", worst},
                          {"worst_apart_px", sorted_sample(worst_px)}};
    list.insert(one.points == MethodPoints::edges ? list.begin() : list.end(), std::move(entry));
  }
  return list;
}

/// Writes a picture as "worst_1.jpg", and lists it with what is said of it.
void add_picture(ordered_json& list, const std::string& prefix, const cv::Mat& picture,
                 const std::string& ending, ordered_json said, const WriteFile& write) {
  said["file"] = fmt::format("{}_{}{}", prefix, list.size() + 1, ending);
  write(said["file"], picture_bytes(picture, ending));
  list.push_back(std::move(said));
}

ordered_json examples(const ComparisonResults& results, const ShowFrame& show, const WriteFile& write) {
  ordered_json list = ordered_json::array();
  for (std::size_t c = 0; c < results.conditions.size() && list.size() < most_examples; ++c) {
    const ConditionInfo& info = results.conditions[c];
    if (info.swept_key.empty())
      add_picture(list, "example", example_photo(show(c, 0)), ".png", {{"condition", info.name}}, write);
  }
  return list;
}

ordered_json notable(const ComparisonResults& results, const std::vector<NotableFrame>& frames,
                     const std::string& name, const ShowFrame& show, const WriteFile& write) {
  ordered_json list = ordered_json::array();
  for (const NotableFrame& frame : frames) {
    const FrameTruth& truth = frame.record.truth;
    const cv::Mat photo = outlines_photo(show(frame.condition, frame.index), frame.record, results.methods);
    add_picture(
        list, name, photo, ".jpg",
        {{"condition", results.conditions[frame.condition].name},
         {"frame", truth.frame},
         {"source", truth.source},
         {"value", frame.value < NotableFrame::not_found ? ordered_json(frame.value) : ordered_json()},
         {"in_space", truth.p_CB.has_value()}},
        write);
  }
  return list;
}

ordered_json photos(const ComparisonResults& results, const ShowFrame& show, const WriteFile& write) {
  if (!show) return ordered_json::object();
  return {{"worst", notable(results, results.worst, "worst", show, write)},
          {"apart", notable(results, results.most_apart, "apart", show, write)},
          {"examples", examples(results, show, write)}};
}

}  // namespace

ordered_json comparison_report(const ComparisonResults& results, const ShowFrame& show,
                               const WriteFile& write) {
  ordered_json methods = ordered_json::array(), settings = ordered_json::array(), roc = ordered_json::array();
  for (const FitMethod* method : results.methods)
    methods.push_back(
        {{"name", method->name}, {"minimises", method->minimises}, {"is_peer", method->is_peer}});
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    if (!results.peer_words[c].empty())
      settings.push_back(results.conditions[c].name + ": " + results.peer_words[c]);
  }
  for (const Certificate& certificate : results.certificates) {
    for (const CertificateRule& rule : certificate.rules)
      roc.push_back({{"one_step", certificate.one_step},
                     {"rule", rule.name},
                     {"false_alarms", rule.roc_false_alarms},
                     {"caught", rule.roc_caught}});
  }
  return {{"page", "comparison"},
          {"break_px", break_px},
          {"enough_next_step_px", enough_next_step_px},
          {"methods", methods},
          {"peer_settings", settings},
          {"one_step_pairs", step_pairs(results)},
          {"roc", roc},
          {"photos", photos(results, show, write)}};
}

}  // namespace ballservo
