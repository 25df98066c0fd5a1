#include "app/commands/color_results.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace ballservo {
namespace {

long cells_of(const ColorTable& colors, std::size_t k) {
  return std::count(colors.table.begin(), colors.table.end(), static_cast<ClassIndex>(k + 1));
}

/// Only as many digits as mean something.
std::string rounded_k(double temperature_k) {
  return fmt::format("{:.0f}", 100 * std::round(temperature_k / 100));
}

}  // namespace

nlohmann::json classes_json(const ColorTable& colors, const std::vector<ClassReport>& reports,
                            const LearntCircles& circles, const std::vector<std::string>& sources) {
  nlohmann::json classes = nlohmann::json::object();
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const ClassReport& report = reports[k];
    const ColorClass& color = colors.classes[k];
    nlohmann::json listed = nlohmann::json::array();
    if (const auto learnt = circles.find(color.name); learnt != circles.end()) {
      for (const LearntCircle& circle : learnt->second) {
        listed.push_back({{"source", sources.at(circle.picture)},
                          {"frame", circle.frame},
                          {"cx_px", circle.center_px.x()},
                          {"cy_px", circle.center_px.y()},
                          {"r_px", circle.radius_px},
                          {"fit_ratio", circle.fit_ratio}});
      }
    }
    classes[color.name] = {{"samples", color.samples},
                           {"circles", listed},
                           {"table_cells", cells_of(colors, k)},
                           {"kept_fraction", report.kept_fraction},
                           {"overlap", report.overlap},
                           {"shared", report.shared},
                           {"background_fraction", report.background_fraction},
                           {"chroma", report.chroma},
                           {"dissolves_at_chroma", report.dissolves_at_chroma},
                           {"light",
                            {{"level_low", report.light.level_low},
                             {"level_high", report.light.level_high},
                             {"warmest_k", report.light.warmest_k},
                             {"coolest_k", report.light.coolest_k},
                             {"warmer_mired", report.light.warmer_mired},
                             {"cooler_mired", report.light.cooler_mired}}}};
  }
  return classes;
}

std::string classes_text(const ColorTable& colors, const std::vector<ClassReport>& reports,
                         const LearntCircles& circles) {
  std::string text;
  for (std::size_t k = 0; k < reports.size(); ++k) {
    const ClassReport& report = reports[k];
    const ColorClass& color = colors.classes[k];
    text += color.name + ": ";
    if (const auto learnt = circles.find(color.name); learnt != circles.end()) {
      text += fmt::format("{} ball{}, ", learnt->second.size(), learnt->second.size() == 1 ? "" : "s");
    }
    text += fmt::format("{} pixels, {} cells of the table, which gives {:.1f} % of the pixels back",
                        color.samples, cells_of(colors, k), 100 * report.kept_fraction);
    for (const auto& [other, fraction] : report.overlap) {
      if (fraction >= 0.01) text += fmt::format(", {:.1f} % to {}", 100 * fraction, other);
    }
    text += fmt::format("\n  background: {:.2f} % of the pixels off the balls have this colour\n",
                        100 * report.background_fraction);
    text += fmt::format("  chroma {:.0f}; fading towards grey, it is lost below {:.0f}\n", report.chroma,
                        report.dissolves_at_chroma);
    text += fmt::format(
        "  light: most of it stays from {:.2g} to {:.2g} times the strength, and from {} to {} K if it was "
        "taught "
        "at 6500 K\n",
        report.light.level_low, report.light.level_high, rounded_k(report.light.warmest_k),
        rounded_k(report.light.coolest_k));
  }
  return text;
}

}  // namespace ballservo
