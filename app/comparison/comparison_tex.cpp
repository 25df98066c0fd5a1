#include <fmt/format.h>

#include <cmath>

#include "app/comparison/comparison_report.hpp"
#include "app/comparison/step_verdict.hpp"

namespace ballservo {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::string_view("_%&#$").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return out;
}

std::string interval(double value, const ConfidenceInterval& ci) {
  return std::isfinite(ci.low) ? fmt::format("{} [{}, {}]", figure(value), figure(ci.low), figure(ci.high))
                               : figure(value);
}

}  // namespace

std::string comparison_tables_tex(const ComparisonResults& results) {
  std::string tex =
      "% Needs \\usepackage{booktabs,longtable}.\n"
      "\\begin{longtable}{llrrrrr}\n\\toprule\n"
      "condition & method & found & median mm [95\\,\\%] & 90\\,\\% mm & depth bias mm & RMS/bound \\\\\n"
      "\\midrule\n\\endhead\n";
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    for (std::size_t m = 0; m < results.methods.size(); ++m) {
      const MethodStatistics& s = results.summaries[c].methods[m];
      tex += fmt::format("{} & {} & {}/{} & {} & {} & {} & {} \\\\\n",
                         m == 0 ? escaped(results.conditions[c].name) : "", escaped(results.methods[m]->name),
                         s.found, s.frames, interval(s.position_median_mm, s.position_median_ci95_mm),
                         figure(s.position_p90_mm), figure(s.depth_bias_mm), figure(s.rms_over_bound));
    }
    tex += c + 1 < results.summaries.size() ? "\\midrule\n" : "";
  }
  tex +=
      "\\bottomrule\n\\end{longtable}\n\n"
      "\\begin{longtable}{lllrrrr}\n\\toprule\n"
      "condition & fit & against & median px [95\\,\\%] & largest px & breaks & median mm [95\\,\\%] "
      "\\\\\n\\midrule\n\\endhead\n";
  const std::vector<MethodPair> pairs = converged_pairs(results.methods);
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const PairStatistics& s = results.summaries[c].pairs[k];
      tex += fmt::format(
          "{} & {} & {} & {} & {} & {}/{} & {} \\\\\n", k == 0 ? escaped(results.conditions[c].name) : "",
          escaped(results.methods[pairs[k].a]->name), escaped(results.methods[pairs[k].b]->name),
          interval(s.center_median_px, s.center_median_ci95_px), figure(s.center_max_px), s.breaks, s.frames,
          interval(s.position_median_mm, s.position_median_ci95_mm));
    }
  }
  return tex + "\\bottomrule\n\\end{longtable}\n";
}

}  // namespace ballservo
