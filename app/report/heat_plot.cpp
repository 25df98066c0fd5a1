#include "app/report/heat_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "app/report/svg_canvas.hpp"
#include "calibration/camera/sphere_outline.hpp"

namespace ballservo {
namespace {

constexpr int shades = 64;

std::vector<PlotColor> palette() {
  cv::Mat grey(1, shades, CV_8UC1), colors;
  for (int i = 0; i < shades; ++i)
    grey.at<std::uint8_t>(i) = static_cast<std::uint8_t>(255 * i / (shades - 1));
  cv::applyColorMap(grey, colors, cv::COLORMAP_VIRIDIS);
  std::vector<PlotColor> result;
  for (int i = 0; i < shades; ++i) {
    const auto& bgr = colors.at<cv::Vec3b>(i);
    result.push_back(PlotColor::rgb(bgr[2], bgr[1], bgr[0]));
  }
  return result;
}

SvgStyle filled(const PlotColor& color) {
  SvgStyle style;
  // An outline of the same colour closes the hairlines between cells.
  style.stroke = style.fill = color;
  style.width_px = 0.6;
  return style;
}

void rectangle(SvgCanvas& canvas, double x0, double y0, double x1, double y1, const SvgStyle& style) {
  canvas.polygon({{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}, style);
}

double largest(const std::vector<double>& values) {
  double high = 0;
  for (const double value : values)
    if (std::isfinite(value)) high = std::max(high, value);
  return high > 0 ? high : 1;
}

void draw_cells(SvgCanvas& canvas, const HeatPlot& plot, const std::vector<PlotColor>& colors, double high) {
  const double right = plot.picture.width_px - 0.5, bottom = plot.picture.height_px - 0.5;
  const double dx = (plot.picture.width_px - 1.0) / (plot.columns - 1);
  const double dy = (plot.picture.height_px - 1.0) / (plot.rows - 1);
  for (int j = 0; j < plot.rows; ++j) {
    for (int i = 0; i < plot.columns; ++i) {
      const double value = plot.values[static_cast<std::size_t>(j * plot.columns + i)];
      if (!std::isfinite(value)) continue;
      const auto shade = static_cast<std::size_t>(std::clamp(value / high, 0.0, 1.0) * (shades - 1));
      rectangle(canvas, std::max(-0.5, (i - 0.5) * dx), std::max(-0.5, (j - 0.5) * dy),
                std::min(right, (i + 0.5) * dx), std::min(bottom, (j + 0.5) * dy), filled(colors[shade]));
    }
  }
}

void draw_arrows(SvgCanvas& canvas, const HeatPlot& plot) {
  if (plot.arrows_px.empty()) return;
  SvgStyle halo, line;
  halo.stroke = PlotColor::rgb(0, 0, 0), halo.width_px = 3, halo.opacity = 0.45;
  line.stroke = PlotColor::rgb(255, 255, 255), line.width_px = 1.4;
  // Every second node, so that neighbours do not run into each other.
  for (int j = 0; j < plot.rows; j += 2) {
    for (int i = 0; i < plot.columns; i += 2) {
      const Eigen::Vector2d from((plot.picture.width_px - 1.0) * i / (plot.columns - 1),
                                 (plot.picture.height_px - 1.0) * j / (plot.rows - 1));
      const Eigen::Vector2d& arrow = plot.arrows_px[static_cast<std::size_t>(j * plot.columns + i)];
      const Eigen::Vector2d to = from + plot.arrow_scale * arrow;
      if (!is_inside_picture({to}, plot.picture)) continue;
      canvas.arrow(from, to, halo, 6);
      canvas.arrow(from, to, line, 5);
    }
  }
}

void draw_scale(SvgCanvas& canvas, const HeatPlot& plot, const std::vector<PlotColor>& colors, double high) {
  const double width = plot.picture.width_px, height = plot.picture.height_px;
  const double left = 1.03 * width, right = 1.06 * width;
  for (int i = 0; i < shades; ++i)
    rectangle(canvas, left, height * (1 - (i + 1.0) / shades), right, height * (1 - i / double{shades}),
              filled(colors[static_cast<std::size_t>(i)]));
  const bool more = largest(plot.values) > 1.0001 * high;
  for (int k = 0; k <= 4; ++k)
    canvas.text(
        {right, height * (1 - k / 4.0)},
        fmt::format("{:.3g}{}", high * k / 4, k < 4 ? "" : " " + plot.unit + (more ? " and more" : "")),
        TextAnchor::start, 12, PlotColor::text(),
        {5, k == 4   ? 11.0
            : k == 0 ? 0.0
                     : 4.0});
}

}  // namespace

Svg heat_plot(const HeatPlot& plot) {
  const auto nodes = static_cast<std::size_t>(std::max(0, plot.columns) * std::max(0, plot.rows));
  if (plot.columns < 2 || plot.rows < 2 || plot.values.size() != nodes ||
      (!plot.arrows_px.empty() && plot.arrows_px.size() != nodes))
    throw std::invalid_argument("a heat plot needs a value for each of its columns x rows");
  const double high = plot.high && *plot.high > 0 ? *plot.high : largest(plot.values);
  const std::vector<PlotColor> colors = palette();
  SvgCanvasOptions options;
  options.x_low = -0.5, options.x_high = 1.45 * plot.picture.width_px;
  options.y_low = -0.5, options.y_high = plot.picture.height_px - 0.5;
  options.width_px = plot.width_px;
  options.y_down = true, options.axes = false;
  options.title = plot.title;
  SvgCanvas canvas(options);
  draw_cells(canvas, plot, colors, high);
  SvgStyle frame;
  frame.width_px = 1;
  rectangle(canvas, -0.5, -0.5, plot.picture.width_px - 0.5, plot.picture.height_px - 0.5, frame);
  draw_arrows(canvas, plot);
  draw_scale(canvas, plot, colors, high);
  return canvas.svg();
}

double arrow_scale_for(double length_px, double longest_px) {
  if (!(length_px > 0) || !std::isfinite(length_px)) return 1;
  const double wanted = longest_px / length_px;
  const double decade = std::pow(10.0, std::floor(std::log10(wanted)));
  const double digit = wanted / decade;
  return decade * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

}  // namespace ballservo
