#include "app/comparison/comparison_plots.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "app/report/svg_plot.hpp"

namespace ballservo {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// What a plot has room for; a converged fit has its one step's colour.
struct Headline {
  const char* name;
  int color;
  bool dashed;
};
constexpr std::array<Headline, 9> headlines{{{"sphere_one_step", 0, false},
                                             {"sphere_converged", 0, true},
                                             {"paper_one_step", 1, false},
                                             {"paper_converged", 1, true},
                                             {"vote", 2, false},
                                             {"hough_gradient", 3, false},
                                             {"hough_gradient_alt", 4, false},
                                             {"hsv_contour", 5, false},
                                             {"vpdot2", 6, false}}};

// The same method has the same colour in every drawing.
PlotColor color_of(std::string_view method) {
  const auto headline = std::find_if(headlines.begin(), headlines.end(),
                                     [&](const Headline& h) { return std::string_view(h.name) == method; });
  return headline == headlines.end() ? PlotColor::rgb(140, 86, 75) : PlotColor::series(headline->color);
}

// Narrow enough that a phone shows it whole.
PlotOptions chart(std::string title) {
  PlotOptions options;
  options.title = std::move(title);
  options.width_px = 480;
  options.height_px = 340;
  return options;
}

PlotSeries series_of(const std::string& name, PlotColor color, bool dashed) {
  PlotSeries series;
  series.name = name;
  series.color = color;
  series.dashed = dashed;
  series.style = SeriesStyle::line_and_points;
  return series;
}

// Vertical bars from low to high.
PlotSeries interval_series(PlotColor color) {
  PlotSeries series;
  series.color = color;
  series.width_px = 1.2;
  series.opacity = 0.6;
  return series;
}
void add_interval(PlotSeries& series, double x, const ConfidenceInterval& interval) {
  if (!std::isfinite(interval.low) || !std::isfinite(interval.high)) return;
  for (const double y : {interval.low, interval.high, nan}) {
    series.x.push_back(x);
    series.y.push_back(y);
  }
}

PlotOptions sweep_chart(const std::string& what, const Sweep& sweep) {
  PlotOptions options = chart(what + " against " + sweep.label);
  options.x = {sweep.label, sweep.log, {}, {}};
  return options;
}

std::string break_label() { return fmt::format("{:g} px", break_px); }

// Not finite stays so, and is a gap in a curve.
double at_least(double least, double value) { return std::isfinite(value) ? std::max(least, value) : nan; }

// The part of the values (%) that are at most so large.
PlotSeries share_curve(const std::string& name, std::vector<double> values, PlotColor color, bool dashed) {
  std::sort(values.begin(), values.end());
  PlotSeries curve;
  curve.name = name;
  curve.color = color;
  curve.dashed = dashed;
  curve.style = SeriesStyle::steps;
  for (std::size_t k = 0; k < values.size(); ++k) {
    // Below a ten-thousandth of a pixel two fits are the same for any purpose.
    curve.x.push_back(std::max(values[k], 1e-4));
    curve.y.push_back(100.0 * static_cast<double>(k + 1) / static_cast<double>(values.size()));
  }
  return curve;
}

}  // namespace

Svg sweep_error_plot(const ComparisonResults& results, const Sweep& sweep) {
  std::vector<PlotSeries> all;
  for (const Headline& headline : headlines) {
    const auto m = place_of(results.methods, headline.name);
    if (!m) continue;
    const PlotColor color = PlotColor::series(headline.color);
    PlotSeries curve = series_of(headline.name, color, headline.dashed), bars = interval_series(color);
    for (const std::size_t c : sweep.conditions) {
      const MethodStatistics& s = results.summaries[c].methods[*m];
      curve.x.push_back(results.conditions[c].swept_value);
      curve.y.push_back(s.position_median_mm);
      if (!headline.dashed) add_interval(bars, curve.x.back(), s.position_median_ci95_mm);
    }
    all.push_back(std::move(curve));
    all.push_back(std::move(bars));
  }
  PlotSeries bound = series_of("bound (RMS)", PlotColor::text(), true);
  for (const std::size_t c : sweep.conditions) {
    bound.x.push_back(results.conditions[c].swept_value);
    bound.y.push_back(results.summaries[c].bound_rms_mm);
  }
  all.push_back(std::move(bound));
  PlotOptions options = sweep_chart("3-D error", sweep);
  options.y = {"median error (mm), log", true, {}, {}};
  return line_plot(all, options);
}

Svg sweep_pair_plot(const ComparisonResults& results, const Sweep& sweep) {
  const std::vector<MethodPair> pairs = converged_pairs(results.methods);
  std::vector<PlotSeries> all;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const std::string& name = results.methods[pairs[k].a]->name;
    if (name != "paper_one_step" && name != "sphere_one_step" && name != "paper_steps_10_reselect") continue;
    const PlotColor color = color_of(name);
    PlotSeries median = series_of(name + ", median", color, false),
               largest = series_of(name + ", largest", color, true), bars = interval_series(color);
    for (const std::size_t c : sweep.conditions) {
      const PairStatistics& s = results.summaries[c].pairs[k];
      for (PlotSeries* series : {&median, &largest}) series->x.push_back(results.conditions[c].swept_value);
      median.y.push_back(at_least(1e-5, s.center_median_px));
      largest.y.push_back(at_least(1e-5, s.center_max_px));
      add_interval(
          bars, median.x.back(),
          {at_least(1e-5, s.center_median_ci95_px.low), at_least(1e-5, s.center_median_ci95_px.high)});
    }
    all.push_back(std::move(median));
    all.push_back(std::move(largest));
    all.push_back(std::move(bars));
  }
  PlotOptions options = sweep_chart("Way to the converged fit", sweep);
  options.y = {"between centres (px), log", true, {}, {}};
  options.lines = {{false, break_px, break_label()}};
  return line_plot(all, options);
}

Svg error_bars(const ComparisonResults& results) {
  std::vector<std::string> names;
  std::vector<std::size_t> shown;
  for (std::size_t c = 0; c < results.conditions.size(); ++c) {
    if (!results.conditions[c].swept_key.empty() || shown.size() >= 12) continue;
    shown.push_back(c);
    names.push_back(results.conditions[c].name);
  }
  std::vector<BarGroup> groups;
  for (const char* name : {"sphere_one_step", "paper_one_step", "vote", "hough_gradient",
                           "hough_gradient_alt", "hsv_contour", "vpdot2"}) {
    const auto m = place_of(results.methods, name);
    if (!m) continue;
    BarGroup group{name, {}, color_of(name)};
    for (const std::size_t c : shown) {
      group.values.push_back(results.summaries[c].methods[*m].position_median_mm);
      group.intervals.push_back(results.summaries[c].methods[*m].position_median_ci95_mm);
    }
    groups.push_back(std::move(group));
  }
  PlotOptions options = chart("Error of the ball's centre in 3-D, median");
  options.y = {"error (mm), log", true, {}, {}};
  options.width_px = std::clamp(110 * static_cast<int>(names.size()), options.width_px, 1040);
  return bar_plot(names, groups, options);
}

Svg difference_plot(const ComparisonResults& results, std::size_t pair) {
  const MethodPair methods = converged_pairs(results.methods)[pair];
  std::vector<double> all_px;
  for (const ConditionSummary& summary : results.summaries) {
    const std::vector<double>& px = summary.centers_apart_px[pair];
    all_px.insert(all_px.end(), px.begin(), px.end());
  }
  std::vector<double> worst_px;
  double largest_median = -1;
  std::string worst_name;
  for (std::size_t c = 0; c < results.summaries.size(); ++c) {
    const double median = results.summaries[c].pairs[pair].center_median_px;
    if (!(median > largest_median)) continue;
    largest_median = median;
    worst_px = results.summaries[c].centers_apart_px[pair];
    worst_name = results.conditions[c].name;
  }
  const std::string& name = results.methods[methods.a]->name;
  const std::vector<PlotSeries> curves{share_curve("all conditions", all_px, color_of(name), false),
                                       share_curve("worst: " + worst_name, worst_px, color_of(name), true)};
  PlotOptions options = chart(fmt::format("{} against {}", name, results.methods[methods.b]->name));
  options.x = {"distance between the two centres (px), log", true, 1e-4, {}};
  options.y = {"frames at most so far apart (%)", false, 0.0, 100.0};
  options.lines = {{true, break_px, break_label()}};
  return line_plot(curves, options);
}

Svg scatter_plot(const ComparisonResults& results, const MethodPair& pair) {
  PlotSeries points, diagonal;
  points.style = SeriesStyle::points;
  points.color = color_of(results.methods[pair.a]->name);
  points.marker_px = 3.5;
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const ConditionSummary& summary : results.summaries) {
    const double a = summary.methods[pair.a].position_median_mm,
                 b = summary.methods[pair.b].position_median_mm;
    if (!(a > 0) || !(b > 0)) continue;
    points.x.push_back(b);
    points.y.push_back(a);
    low = std::min({low, a, b});
    high = std::max({high, a, b});
  }
  diagonal.color = PlotColor::text();
  diagonal.dashed = true;
  if (high > 0) {
    diagonal.x = {low, high};
    diagonal.y = {low, high};
  }
  PlotOptions options = chart("Error of one step and of the converged fit, by condition");
  options.x = {results.methods[pair.b]->name + ": median error (mm), log", true, {}, {}};
  options.y = {results.methods[pair.a]->name + ": median error (mm), log", true, {}, {}};
  return line_plot({points, diagonal}, options);
}

Svg ellipse_plot(const ComparisonResults& results, std::size_t condition) {
  std::vector<PlotSeries> all;
  for (const char* name : {"sphere_one_step", "paper_one_step", "vote"}) {
    const auto m = place_of(results.methods, name);
    if (!m) continue;
    const MethodStatistics& s = results.summaries[condition].methods[*m];
    if (!std::isfinite(s.depth_spread_mm) || !std::isfinite(s.lateral_spread_mm)) continue;
    PlotSeries ellipse;
    ellipse.name = name;
    ellipse.color = color_of(name);
    // One of the two sideways directions has its share of the spread.
    const double across = s.lateral_spread_mm / std::sqrt(2.0);
    for (int k = 0; k <= 72; ++k) {
      const double angle = 2 * M_PI * k / 72;
      ellipse.x.push_back(s.lateral_bias_mm + 2 * across * std::cos(angle));
      ellipse.y.push_back(s.depth_bias_mm + 2 * s.depth_spread_mm * std::sin(angle));
    }
    all.push_back(std::move(ellipse));
  }
  PlotOptions options = chart("Where the errors lie: " + results.conditions[condition].name);
  options.x = {"sideways, outward (mm)", false, {}, {}};
  options.y = {"depth (mm)", false, {}, {}};
  return line_plot(all, options);
}

Svg cost_plot(const ComparisonResults& results) {
  std::vector<PlotSeries> all;
  for (const Headline& headline : headlines) {
    const auto m = place_of(results.methods, headline.name);
    if (!m) continue;
    std::vector<double> times_ms, errors_mm;
    for (const ConditionSummary& summary : results.summaries) {
      const MethodStatistics& s = summary.methods[*m];
      if (std::isfinite(s.time_us_median)) times_ms.push_back(s.time_us_median / 1000);
      if (std::isfinite(s.position_median_mm)) errors_mm.push_back(s.position_median_mm);
    }
    PlotSeries point;
    point.name = headline.name;
    point.style = SeriesStyle::points;
    point.marker_px = headline.dashed ? 3 : 5;
    point.color = PlotColor::series(headline.color);
    point.opacity = headline.dashed ? 0.5 : 1;
    point.x = {median(times_ms)};
    point.y = {median(errors_mm)};
    all.push_back(std::move(point));
  }
  PlotOptions options = chart("What each costs, and how well it does");
  options.x = {"time a frame (ms), log", true, {}, {}};
  options.y = {"median error (mm), log", true, {}, {}};
  return line_plot(all, options);
}

Svg roc_plot(const std::vector<Certificate>& certificates) {
  std::vector<PlotSeries> all;
  for (const Certificate& certificate : certificates) {
    for (const CertificateRule& rule : certificate.rules) {
      if (rule.tested.breaks < fewest_breaks_drawn || rule.roc_caught.empty()) continue;
      PlotSeries curve;
      curve.name = certificate.one_step + ", " + rule.name;
      curve.color = color_of(certificate.one_step);
      curve.dashed = &rule != &certificate.rules.front();
      curve.opacity = &rule == &certificate.rules.back() ? 0.5 : 1;
      for (const double rate : rule.roc_false_alarms) curve.x.push_back(100 * rate);
      for (const double rate : rule.roc_caught) curve.y.push_back(100 * rate);
      all.push_back(std::move(curve));
    }
  }
  PlotOptions options = chart("How well the rules tell breaks");
  options.x = {"false alarms (% of the frames that do not break)", false, 0.0, 100.0};
  options.y = {"breaks caught (%)", false, 0.0, 100.0};
  options.lines = {{true, 5, "5 %"}, {false, 95, "95 %"}};
  return line_plot(all, options);
}

}  // namespace ballservo
