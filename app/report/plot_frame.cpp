#include "app/report/plot_frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr double tick_text_px = 11, label_text_px = 12, title_text_px = 14;
constexpr double legend_row_px = 18, tick_line_px = 13;

SvgStyle hairline(double opacity) {
  SvgStyle style;
  style.width_px = 1;
  style.opacity = opacity;
  return style;
}

double entry_width_px(const LegendEntry& entry) { return 40 + text_width_px(entry.name, label_text_px); }

int legend_rows(const std::vector<LegendEntry>& legend, double width_px) {
  int rows = legend.empty() ? 0 : 1;
  double used = 0;
  for (const LegendEntry& entry : legend) {
    if (used > 0 && used + entry_width_px(entry) > width_px) {
      ++rows;
      used = 0;
    }
    used += entry_width_px(entry);
  }
  return rows;
}

// A name in lines of at most so much room where it can be broken: behind '_' and ' '.
std::vector<std::string> lines_of(const std::string& name, double width_px) {
  std::vector<std::string> lines(1);
  for (std::size_t begin = 0; begin < name.size();) {
    const std::size_t end = std::min(name.find_first_of("_ ", begin), name.size() - 1) + 1;
    const std::string piece = name.substr(begin, end - begin);
    if (!lines.back().empty() && text_width_px(lines.back() + piece, tick_text_px) > width_px)
      lines.emplace_back();
    lines.back() += piece;
    begin = end;
  }
  return lines;
}

std::vector<Tick> axis_ticks(const PlotAxis& axis, const AxisRange& range, double length_px,
                             double spacing_px) {
  const int count = std::max(2, static_cast<int>(length_px / spacing_px));
  return axis.log ? log_ticks(range.low, range.high, count) : linear_ticks(range.low, range.high, count);
}

}  // namespace

AxisRange axis_range(const PlotAxis& axis, const AxisRange& data) {
  AxisRange range = data;
  if (axis.low && showable(*axis.low, axis.log)) range.low = *axis.low;
  if (axis.high && showable(*axis.high, axis.log)) range.high = *axis.high;
  return range.low < range.high ? range : data;
}

PlotFrame::PlotFrame(const PlotOptions& options, AxisRange x, AxisRange y,
                     const std::vector<LegendEntry>& legend, const std::vector<std::string>& categories)
    : options_(options), x_(x), y_(y) {
  options_.width_px = std::clamp(options.width_px, 160, 4000);
  options_.height_px = std::clamp(options.height_px, 160, 4000);
  double top = 10;
  if (!options_.title.empty()) top += title_text_px + 8;
  const int rows = legend_rows(legend, options_.width_px - 70);
  top += rows * legend_row_px + (rows > 0 ? 4 : 0);
  std::vector<std::vector<std::string>> names;
  std::size_t most_lines = 1;
  for (const std::string& category : categories) {
    names.push_back(lines_of(category, 0.9 * options_.width_px / static_cast<double>(categories.size())));
    most_lines = std::max(most_lines, names.back().size());
  }
  const double bottom =
      26 + tick_line_px * static_cast<double>(most_lines - 1) + (options_.x.label.empty() ? 0 : 20);
  top_ = top;
  x_label_px_ = bottom - 10;
  height_ = std::max(60.0, options_.height_px - top - bottom);

  // The y axis's labels decide how much room they need, and so what is left for x.
  const std::vector<Tick> y_ticks = axis_ticks(options_.y, y_, height_, 44);
  double widest = 0;
  for (const Tick& tick : y_ticks) widest = std::max(widest, text_width_px(tick.label, tick_text_px));
  left_ = 14 + widest + (options_.y.label.empty() ? 0 : 20);
  width_ = std::max(60.0, options_.width_px - left_ - 16);

  std::vector<Tick> y_final = y_ticks;
  if (options_.equal_aspect && !options_.x.log && !options_.y.log) {
    const double per_px = std::max((x_.high - x_.low) / width_, (y_.high - y_.low) / height_);
    const double x_middle = (x_.low + x_.high) / 2, y_middle = (y_.low + y_.high) / 2;
    x_ = {x_middle - per_px * width_ / 2, x_middle + per_px * width_ / 2};
    y_ = {y_middle - per_px * height_ / 2, y_middle + per_px * height_ / 2};
    y_final = axis_ticks(options_.y, y_, height_, 44);
  }
  draw_legend(legend);
  draw_axes(categories.empty() ? axis_ticks(options_.x, x_, width_, 80) : std::vector<Tick>{}, y_final,
            names);
  writer_.begin_clip({left_, top_}, {width_, height_});
}

double PlotFrame::unit(double value, const AxisRange& range, bool log) const {
  if (!showable(value, log)) return std::numeric_limits<double>::quiet_NaN();
  const double position = log ? std::log(value / range.low) / std::log(range.high / range.low)
                              : (value - range.low) / (range.high - range.low);
  // Far outside is as good as just outside, and keeps lines that leave the plot.
  return std::clamp(position, -100.0, 100.0);
}

Eigen::Vector2d PlotFrame::pixel(double x, double y) const {
  const double up = unit(y, y_, options_.y.log);
  return {left_ + width_ * unit(x, x_, options_.x.log), top_ + height_ * (options_.y_down ? up : 1 - up)};
}

void PlotFrame::draw_legend(const std::vector<LegendEntry>& legend) {
  double y = 10;
  if (!options_.title.empty()) {
    writer_.text({options_.width_px / 2.0, y + title_text_px}, options_.title, TextAnchor::middle,
                 title_text_px, true);
    y += title_text_px + 8;
  }
  double x = 50;
  for (const LegendEntry& entry : legend) {
    if (x > 50 && x + entry_width_px(entry) > options_.width_px - 20) {
      x = 50;
      y += legend_row_px;
    }
    SvgStyle style;
    style.stroke = entry.color;
    style.dashed = entry.dashed;
    style.width_px = 2.5;
    style.opacity = entry.opacity;
    if (entry.area || entry.marker_px > 0) {
      style.fill = entry.color;
      style.stroke.reset();
    }
    if (entry.area) {
      writer_.rectangle({x + 8, y + 4}, {11, 11}, style);
    } else if (entry.marker_px > 0) {
      writer_.ellipse({x + 13, y + 10}, entry.marker_px, entry.marker_px, 0, style);
    } else {
      writer_.line({x, y + 10}, {x + 20, y + 10}, style);
    }
    writer_.text({x + 25, y + 14}, entry.name, TextAnchor::start, label_text_px);
    x += entry_width_px(entry);
  }
}

void PlotFrame::draw_axes(const std::vector<Tick>& x_ticks, const std::vector<Tick>& y_ticks,
                          const std::vector<std::vector<std::string>>& categories) {
  const double bottom = bottom_px(), right = left_ + width_;
  for (const Tick& tick : x_ticks) {
    const double x = pixel(tick.value, y_.low).x();
    writer_.line({x, top_}, {x, bottom}, hairline(tick.label.empty() ? 0.07 : 0.15));
    writer_.text({x, bottom + 16}, tick.label, TextAnchor::middle, tick_text_px);
  }
  for (std::size_t k = 0; k < categories.size(); ++k) {
    const double x = left_ + width_ * unit(static_cast<double>(k), x_, false);
    for (std::size_t line = 0; line < categories[k].size(); ++line) {
      writer_.text({x, bottom + 16 + tick_line_px * static_cast<double>(line)}, categories[k][line],
                   TextAnchor::middle, tick_text_px);
    }
  }
  for (const Tick& tick : y_ticks) {
    const double y = pixel(x_.low, tick.value).y();
    writer_.line({left_, y}, {right, y}, hairline(tick.label.empty() ? 0.07 : 0.15));
    writer_.text({left_ - 6, y + 4}, tick.label, TextAnchor::end, tick_text_px);
  }
  writer_.line({left_, bottom}, {right, bottom}, hairline(0.7));
  writer_.line({left_, top_}, {left_, bottom}, hairline(0.7));
  writer_.text({left_ + width_ / 2, bottom + x_label_px_}, options_.x.label, TextAnchor::middle,
               label_text_px);
  writer_.text({16, top_ + height_ / 2}, options_.y.label, TextAnchor::middle, label_text_px, false, true);
}

Svg PlotFrame::finish() {
  SvgStyle style = hairline(0.6);
  style.dashed = true;
  for (const ReferenceLine& line : options_.lines) {
    if (!showable(line.value, line.vertical ? options_.x.log : options_.y.log)) continue;
    if (line.vertical) {
      const double x = pixel(line.value, y_.low).x();
      writer_.line({x, top_}, {x, bottom_px()}, style);
      const bool fits = x + 8 + text_width_px(line.label, tick_text_px) < left_ + width_;
      writer_.text({fits ? x + 4 : x - 4, top_ + 12}, line.label, fits ? TextAnchor::start : TextAnchor::end,
                   tick_text_px, false, false, PlotColor::text(), 0.8);
    } else {
      const double y = pixel(x_.low, line.value).y();
      writer_.line({left_, y}, {left_ + width_, y}, style);
      const double text_y = y - 4 < top_ + tick_text_px ? y + 13 : y - 4;
      writer_.text({left_ + width_ - 4, text_y}, line.label, TextAnchor::end, tick_text_px, false, false,
                   PlotColor::text(), 0.8);
    }
  }
  writer_.end_clip();
  const std::string label =
      options_.title.empty() ? options_.y.label + " over " + options_.x.label : options_.title;
  return writer_.finish(options_.width_px, options_.height_px, label);
}

}  // namespace ballservo
