// Plots with axes: lines, points, bars, histograms. Values that are not finite are gaps.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/report/svg.hpp"
#include "calibration/base/statistics.hpp"

namespace ballservo {

/// One axis. Write the unit into the label: "range (m)".
struct PlotAxis {
  std::string label;
  bool log = false;  ///< values of 0 and below are gaps then
  std::optional<double> low,
      high;  ///< fixed ends; by the data where missing or useless (not finite, low >= high)
};

enum class SeriesStyle { line, points, line_and_points, steps };

/// One curve or cloud of points. Where x and y differ in length the shorter counts.
struct PlotSeries {
  std::string name;  ///< in the legend; empty: not in it
  std::vector<double> x, y;
  SeriesStyle style = SeriesStyle::line;
  std::optional<PlotColor> color{};  ///< by the series' place in the list where missing
  bool dashed = false;
  double width_px = 1.8;   ///< of the line
  double marker_px = 2.5;  ///< radius of the points
  double opacity = 1;
};

/// A straight line across the whole plot, such as a goal or a limit.
struct ReferenceLine {
  bool vertical = false;
  double value = 0;
  std::string label;
};

struct PlotOptions {
  std::string title;
  PlotAxis x, y;
  int width_px = 640, height_px = 340;  ///< of the whole drawing, between 160 and 4000
  bool equal_aspect = false;            ///< one unit is as long in x as in y (not with a log axis)
  bool y_down = false;                  ///< y grows downwards, as in a picture
  std::vector<ReferenceLine> lines;
};

Svg line_plot(const std::vector<PlotSeries>& series, const PlotOptions& options);

/// How often values fall into `bins` equal cells of the x axis (its fixed ends, or the range of the finite
/// values).
Svg histogram_plot(const std::vector<double>& values, int bins, const PlotOptions& options);

/// Bars side by side for each category; one value of each group a category.
struct BarGroup {
  std::string name;
  std::vector<double> values;
  std::optional<PlotColor> color{};             ///< by the group's place in the list where missing
  std::vector<ConfidenceInterval> intervals{};  ///< of the values, drawn as thin lines; none, or one for each
};
/// The x axis's options are its label only. With a log y axis the bars stand on its lower end.
Svg bar_plot(const std::vector<std::string>& categories, const std::vector<BarGroup>& groups,
             const PlotOptions& options);

}  // namespace ballservo
