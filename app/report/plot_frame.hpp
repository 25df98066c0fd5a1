// The frame that every plot stands in: title, legend, axes, ticks, and the way from values to pixels.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "app/report/svg_plot.hpp"
#include "app/report/svg_writer.hpp"
#include "app/report/ticks.hpp"

namespace ballservo {

struct LegendEntry {
  std::string name;
  PlotColor color;
  bool dashed = false;
  bool area = false;     ///< a filled square, for bars
  double marker_px = 0;  ///< a dot of this radius instead of a line
  double opacity = 1;
};

/// Lays out a plot for known axis ranges; draws what lies below the data at once and what lies above it in
/// `finish`.
class PlotFrame {
 public:
  /// `categories`: names along the x axis instead of ticks, category k at x = k; empty for an axis of
  /// numbers.
  PlotFrame(const PlotOptions& options, AxisRange x, AxisRange y, const std::vector<LegendEntry>& legend,
            const std::vector<std::string>& categories);

  /// The drawing's pixel of a value; NaN where the axis can't show it.
  Eigen::Vector2d pixel(double x, double y) const;
  double bottom_px() const { return top_ + height_; }
  AxisRange y_range() const { return y_; }
  SvgWriter& writer() { return writer_; }

  Svg finish();

 private:
  double unit(double value, const AxisRange& range, bool log) const;
  void draw_legend(const std::vector<LegendEntry>& legend);
  void draw_axes(const std::vector<Tick>& x_ticks, const std::vector<Tick>& y_ticks,
                 const std::vector<std::vector<std::string>>& categories);

  PlotOptions options_;
  AxisRange x_, y_;
  double left_ = 0, top_ = 0, width_ = 0, height_ = 0;
  double x_label_px_ = 0;  // how far below the axis it stands
  SvgWriter writer_;
};

/// The fixed ends of an axis where they are useful, the data's where not.
AxisRange axis_range(const PlotAxis& axis, const AxisRange& data);

}  // namespace ballservo
