#include "app/report/svg_writer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/report/html_text.hpp"

namespace ballservo {
namespace {

constexpr double largest_px = 9e5;

bool drawable(double value) { return std::abs(value) <= largest_px; }
bool drawable(const Eigen::Vector2d& point) { return drawable(point.x()) && drawable(point.y()); }

// Hundredths of a pixel, without a ".00" or a "-0".
std::string px(double value) {
  const double rounded = std::round(value * 100) / 100 + 0.0;
  if (rounded == std::round(rounded)) return fmt::format("{:.0f}", rounded == 0 ? 0.0 : rounded);
  return fmt::format("{:.2f}", rounded);
}

std::string style_attributes(const SvgStyle& style) {
  std::string attributes;
  attributes += style.fill ? fmt::format(" fill=\"{}\"", style.fill->css()) : " fill=\"none\"";
  if (style.fill && style.fill_opacity < 1) {
    attributes += fmt::format(" fill-opacity=\"{}\"", px(std::max(0.0, style.fill_opacity)));
  }
  if (style.stroke && drawable(style.width_px)) {
    attributes += fmt::format(" stroke=\"{}\" stroke-width=\"{}\"", style.stroke->css(), px(style.width_px));
    if (style.dashed) attributes += " stroke-dasharray=\"6 4\"";
  }
  if (style.opacity < 1) attributes += fmt::format(" opacity=\"{}\"", px(std::max(0.0, style.opacity)));
  return attributes;
}

std::string point_list(const std::vector<Eigen::Vector2d>& points) {
  std::string list;
  for (const Eigen::Vector2d& point : points) {
    if (!list.empty()) list += ' ';
    list += px(point.x()) + "," + px(point.y());
  }
  return list;
}

std::string_view anchor_name(TextAnchor anchor) {
  switch (anchor) {
    case TextAnchor::start:
      return "start";
    case TextAnchor::middle:
      return "middle";
    case TextAnchor::end:
      return "end";
  }
  return "start";
}

}  // namespace

PlotColor PlotColor::series(int index) {
  constexpr std::array<std::uint32_t, palette_size> palette{0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7,
                                                            0xe69f00, 0x56b4e9, 0x888888};
  PlotColor color;
  color.rgb_ = palette[static_cast<std::size_t>(std::max(index, 0)) % palette.size()];
  return color;
}

PlotColor PlotColor::rgb(std::uint8_t red, std::uint8_t green, std::uint8_t blue) {
  PlotColor color;
  color.rgb_ = (std::uint32_t{red} << 16) | (std::uint32_t{green} << 8) | blue;
  return color;
}

std::string PlotColor::css() const { return rgb_ ? fmt::format("#{:06x}", *rgb_) : "currentColor"; }

Svg::Svg(std::string body, int width_px, int height_px, const std::string& label)
    : body_(std::move(body)), width_px_(width_px), height_px_(height_px) {
  markup_ = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" aria-label=\"{2}\" "
      "font-family=\"system-ui, sans-serif\">\n{3}</svg>\n",
      width_px, height_px, html_escape(label), body_);
}

std::string Svg::standalone() const {
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "color=\"#222222\" "
      "font-family=\"DejaVu Sans, sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" "
      "fill=\"#ffffff\"/>\n{2}</svg>\n",
      width_px_, height_px_, body_);
}

void SvgWriter::line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const SvgStyle& style) {
  if (!drawable(from) || !drawable(to)) return;
  body_ += fmt::format("<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"{}/>\n", px(from.x()), px(from.y()),
                       px(to.x()), px(to.y()), style_attributes(style));
}

void SvgWriter::polyline(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style) {
  // Points closer than this to the one before them would not be seen; leaving them out keeps long logs small.
  constexpr double closest_px = 0.3;
  std::vector<Eigen::Vector2d> piece;
  const auto flush = [&] {
    if (piece.size() == 1) {
      SvgStyle dot = style;
      dot.fill = style.stroke;
      dot.stroke.reset();
      ellipse(piece[0], style.width_px, style.width_px, 0, dot);
    } else if (piece.size() > 1) {
      body_ += fmt::format("<polyline points=\"{}\"{} stroke-linejoin=\"round\"/>\n", point_list(piece),
                           style_attributes(style));
    }
    piece.clear();
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!drawable(points[i])) {
      flush();
      continue;
    }
    const bool last = i + 1 == points.size() || !drawable(points[i + 1]);
    if (!piece.empty() && !last && (points[i] - piece.back()).lpNorm<Eigen::Infinity>() < closest_px)
      continue;
    piece.push_back(points[i]);
  }
  flush();
}

void SvgWriter::polygon(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style) {
  if (points.size() < 2 ||
      !std::all_of(points.begin(), points.end(), [](const auto& p) { return drawable(p); }))
    return;
  body_ += fmt::format("<polygon points=\"{}\"{}/>\n", point_list(points), style_attributes(style));
}

void SvgWriter::rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const SvgStyle& style) {
  if (!drawable(corner) || !drawable(size) || size.x() < 0 || size.y() < 0) return;
  body_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}/>\n", px(corner.x()),
                       px(corner.y()), px(size.x()), px(size.y()), style_attributes(style));
}

void SvgWriter::ellipse(const Eigen::Vector2d& center, double semi_a, double semi_b, double angle_rad,
                        const SvgStyle& style) {
  if (!drawable(center) || !drawable(semi_a) || !drawable(semi_b) || !drawable(angle_rad)) return;
  if (semi_a < 0 || semi_b < 0) return;
  if (semi_a == semi_b) {
    body_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\"{}/>\n", px(center.x()), px(center.y()),
                         px(semi_a), style_attributes(style));
    return;
  }
  body_ += fmt::format(
      "<ellipse cx=\"{0}\" cy=\"{1}\" rx=\"{2}\" ry=\"{3}\" transform=\"rotate({4} {0} {1})\"{5}/>\n",
      px(center.x()), px(center.y()), px(semi_a), px(semi_b), px(angle_rad * 180 / M_PI),
      style_attributes(style));
}

void SvgWriter::text(const Eigen::Vector2d& at, std::string_view text, TextAnchor anchor, double size_px,
                     bool bold, bool turned, const PlotColor& color, double opacity) {
  if (!drawable(at) || !drawable(size_px) || text.empty()) return;
  std::string attributes = fmt::format("x=\"{}\" y=\"{}\" text-anchor=\"{}\" font-size=\"{}\" fill=\"{}\"",
                                       px(at.x()), px(at.y()), anchor_name(anchor), px(size_px), color.css());
  if (bold) attributes += " font-weight=\"600\"";
  if (opacity < 1) attributes += fmt::format(" opacity=\"{}\"", px(std::max(0.0, opacity)));
  if (turned) attributes += fmt::format(" transform=\"rotate(-90 {} {})\"", px(at.x()), px(at.y()));
  body_ += fmt::format("<text {}>{}</text>\n", attributes, html_escape(text));
}

void SvgWriter::arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double head_px,
                      const SvgStyle& style) {
  const Eigen::Vector2d along = to - from;
  const double length = along.norm();
  if (!drawable(from) || !drawable(to) || length < 1e-9) return;
  const double head = std::min(head_px, length);
  const Eigen::Vector2d forward = along / length, side(-forward.y(), forward.x());
  const Eigen::Vector2d base = to - head * forward;
  line(from, base, style);
  SvgStyle filled = style;
  filled.fill = style.stroke;
  filled.stroke.reset();
  polygon({to, base + 0.4 * head * side, base - 0.4 * head * side}, filled);
}

void SvgWriter::drawing(const Eigen::Vector2d& corner, const Svg& drawing) {
  if (!drawable(corner)) return;
  body_ += fmt::format("<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\">\n{}</svg>\n", px(corner.x()),
                       px(corner.y()), drawing.width_px_, drawing.height_px_, drawing.body_);
}

// A nested <svg> clips without an identifier, which would have to be unique over the whole page.
void SvgWriter::begin_clip(const Eigen::Vector2d& corner, const Eigen::Vector2d& size) {
  body_ += fmt::format(
      "<svg x=\"{0}\" y=\"{1}\" width=\"{2}\" height=\"{3}\" viewBox=\"{0} {1} {2} {3}\" "
      "overflow=\"hidden\">\n",
      px(corner.x()), px(corner.y()), px(size.x()), px(size.y()));
}

void SvgWriter::end_clip() { body_ += "</svg>\n"; }

Svg SvgWriter::finish(int width_px, int height_px, const std::string& label) const {
  return Svg(body_, width_px, height_px, label);
}

double text_width_px(std::string_view text, double size_px) {
  // Continuation bytes of UTF-8 take no room of their own.
  const auto letters = std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; });
  return 0.56 * size_px * static_cast<double>(letters);
}

}  // namespace ballservo
