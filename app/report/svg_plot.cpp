#include "app/report/svg_plot.hpp"

#include <algorithm>
#include <cmath>

#include "app/report/plot_frame.hpp"

namespace ballservo {
namespace {

// Of a series or a group of bars.
template <class Series>
PlotColor color_of(const std::vector<Series>& series, std::size_t k) {
  return series[k].color.value_or(PlotColor::series(static_cast<int>(k)));
}

std::vector<Eigen::Vector2d> as_steps(const std::vector<Eigen::Vector2d>& points) {
  std::vector<Eigen::Vector2d> steps;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) steps.emplace_back(points[i].x(), points[i - 1].y());
    steps.push_back(points[i]);
  }
  return steps;
}

// Series beyond the palette take its colours again, dashed.
bool dashed(const std::vector<PlotSeries>& series, std::size_t k) {
  return series[k].dashed || (!series[k].color && static_cast<int>(k) >= PlotColor::palette_size);
}

void draw_series(PlotFrame& frame, const PlotSeries& series, const PlotColor& color, bool is_dashed) {
  std::vector<Eigen::Vector2d> points;
  const std::size_t count = std::min(series.x.size(), series.y.size());
  for (std::size_t i = 0; i < count; ++i) points.push_back(frame.pixel(series.x[i], series.y[i]));

  SvgStyle line;
  line.stroke = color;
  line.width_px = series.width_px;
  line.dashed = is_dashed;
  line.opacity = series.opacity;
  if (series.style == SeriesStyle::steps) frame.writer().polyline(as_steps(points), line);
  if (series.style == SeriesStyle::line || series.style == SeriesStyle::line_and_points) {
    frame.writer().polyline(points, line);
  }
  if (series.style == SeriesStyle::points || series.style == SeriesStyle::line_and_points) {
    SvgStyle dot;
    dot.stroke.reset();
    dot.fill = color;
    dot.opacity = series.opacity;
    for (const Eigen::Vector2d& point : points)
      frame.writer().ellipse(point, series.marker_px, series.marker_px, 0, dot);
  }
}

}  // namespace

Svg line_plot(const std::vector<PlotSeries>& series, const PlotOptions& options) {
  // Only points that are drawn count for the axes: a gap in y hides its x.
  std::vector<double> xs, ys;
  std::vector<LegendEntry> legend;
  for (std::size_t k = 0; k < series.size(); ++k) {
    const std::size_t count = std::min(series[k].x.size(), series[k].y.size());
    for (std::size_t i = 0; i < count; ++i) {
      if (!showable(series[k].x[i], options.x.log) || !showable(series[k].y[i], options.y.log)) continue;
      xs.push_back(series[k].x[i]);
      ys.push_back(series[k].y[i]);
    }
    if (series[k].name.empty()) continue;
    legend.push_back({series[k].name, color_of(series, k), dashed(series, k)});
    legend.back().marker_px = series[k].style == SeriesStyle::points ? series[k].marker_px : 0;
    legend.back().opacity = series[k].opacity;
  }
  for (const ReferenceLine& line : options.lines) (line.vertical ? xs : ys).push_back(line.value);
  AxisRange x = range_of(xs, options.x.log);
  if (!options.x.log && !xs.empty() && !options.equal_aspect) {
    // Curves run from edge to edge; clouds of points keep some room.
    const bool only_lines = std::all_of(series.begin(), series.end(), [](const PlotSeries& s) {
      return s.style == SeriesStyle::line || s.style == SeriesStyle::steps;
    });
    const auto [low, high] = std::minmax_element(xs.begin(), xs.end());
    if (only_lines && showable(*low, false) && showable(*high, false) && *low < *high) x = {*low, *high};
  }
  PlotFrame frame(options, axis_range(options.x, x), axis_range(options.y, range_of(ys, options.y.log)),
                  legend, {});
  for (std::size_t k = 0; k < series.size(); ++k)
    draw_series(frame, series[k], color_of(series, k), dashed(series, k));
  return frame.finish();
}

Svg histogram_plot(const std::vector<double>& values, int bins, const PlotOptions& options) {
  const int count = std::clamp(bins, 1, 1000);
  PlotOptions shown = options;
  shown.x.log = false;
  const AxisRange x = axis_range(shown.x, range_of(values, false));
  std::vector<double> counts(static_cast<std::size_t>(count), 0.0);
  for (const double value : values) {
    if (!(value >= x.low && value <= x.high)) continue;
    const int bin = std::min(count - 1, static_cast<int>((value - x.low) / (x.high - x.low) * count));
    ++counts[static_cast<std::size_t>(bin)];
  }
  const double most = std::max(1.0, *std::max_element(counts.begin(), counts.end()));
  const double least = shown.y.log ? 0.5 : 0.0;
  PlotFrame frame(shown, x, axis_range(shown.y, {least, 1.05 * most}), {}, {});
  SvgStyle bar;
  bar.stroke.reset();
  bar.fill = PlotColor::series(0);
  bar.opacity = 0.85;
  const double cell = (x.high - x.low) / count;
  for (int k = 0; k < count; ++k) {
    const double height = counts[static_cast<std::size_t>(k)];
    if (height <= 0) continue;
    const Eigen::Vector2d a = frame.pixel(x.low + k * cell, height);
    const Eigen::Vector2d b = frame.pixel(x.low + (k + 1) * cell, frame.y_range().low);
    const double gap = b.x() - a.x() > 4 ? 1 : 0;
    frame.writer().rectangle({a.x(), std::min(a.y(), b.y())}, {b.x() - a.x() - gap, std::abs(b.y() - a.y())},
                             bar);
  }
  return frame.finish();
}

Svg bar_plot(const std::vector<std::string>& categories, const std::vector<BarGroup>& groups,
             const PlotOptions& options) {
  PlotOptions shown = options;
  shown.x.log = false;
  shown.equal_aspect = false;
  std::vector<double> values;
  std::vector<LegendEntry> legend;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    values.insert(values.end(), groups[g].values.begin(), groups[g].values.end());
    for (const ConfidenceInterval& interval : groups[g].intervals)
      values.insert(values.end(), {interval.low, interval.high});
    legend.push_back({groups[g].name, color_of(groups, g), false, true});
  }
  for (const ReferenceLine& line : shown.lines) {
    if (!line.vertical) values.push_back(line.value);
  }
  if (!shown.y.log) values.push_back(0);
  AxisRange y = range_of(values, shown.y.log);
  if (!shown.y.log) {
    // Bars stand on zero itself when nothing reaches below it.
    const bool below =
        std::any_of(values.begin(), values.end(), [](double v) { return showable(v, false) && v < 0; });
    if (!below) y.low = 0;
  } else {
    y.low /= 1.5;
  }
  const double n = static_cast<double>(std::max<std::size_t>(categories.size(), 1));
  PlotFrame frame(shown, {-0.5, n - 0.5}, axis_range(shown.y, y), legend, categories);
  const double base = shown.y.log ? frame.y_range().low : 0;
  const double width = 0.8 / static_cast<double>(std::max<std::size_t>(groups.size(), 1));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    SvgStyle bar;
    bar.stroke.reset();
    bar.fill = color_of(groups, g);
    SvgStyle whisker;
    whisker.stroke = PlotColor::text();
    whisker.opacity = 0.6;
    for (std::size_t k = 0; k < std::min(categories.size(), groups[g].values.size()); ++k) {
      const double value = groups[g].values[k];
      if (!showable(value, shown.y.log)) continue;
      const double x = static_cast<double>(k) - 0.4 + width * static_cast<double>(g);
      const Eigen::Vector2d a = frame.pixel(x, value), b = frame.pixel(x + width, base);
      frame.writer().rectangle({a.x(), std::min(a.y(), b.y())},
                               {std::max(0.5, b.x() - a.x() - 1), std::abs(b.y() - a.y())}, bar);
      if (k >= groups[g].intervals.size()) continue;
      const ConfidenceInterval& interval = groups[g].intervals[k];
      if (!showable(interval.low, shown.y.log) || !showable(interval.high, shown.y.log)) continue;
      const double middle = x + width / 2;
      frame.writer().line(frame.pixel(middle, interval.low), frame.pixel(middle, interval.high), whisker);
    }
  }
  return frame.finish();
}

}  // namespace ballservo
