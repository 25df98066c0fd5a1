// Elements of SVG in the drawing's own pixels: what plots and canvases are made of. Nothing that is not
// finite is ever written.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "app/report/svg.hpp"

namespace ballservo {

enum class TextAnchor { start, middle, end };

/// Collects elements; x to the right, y down, pixels of the drawing. An element with a coordinate that is not
/// finite or beyond 900000 pixels is left out (a polyline is broken there).
class SvgWriter {
 public:
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const SvgStyle& style);
  /// Broken into pieces where a point is not finite; a piece of one point is drawn as a dot.
  void polyline(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style);
  void polygon(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style);
  void rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const SvgStyle& style);
  /// `angle_rad` turns the first semi-axis from x towards y (down).
  void ellipse(const Eigen::Vector2d& center, double semi_a, double semi_b, double angle_rad,
               const SvgStyle& style);
  /// `turned`: reads upwards.
  void text(const Eigen::Vector2d& at, std::string_view text, TextAnchor anchor, double size_px,
            bool bold = false, bool turned = false, const PlotColor& color = PlotColor::text(),
            double opacity = 1);
  /// A shaft and a filled head of `head_px`.
  void arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double head_px, const SvgStyle& style);
  /// A whole drawing, its upper left corner at `corner`.
  void drawing(const Eigen::Vector2d& corner, const Svg& drawing);
  /// What follows is clipped to a rectangle, in the drawing's coordinates as before.
  void begin_clip(const Eigen::Vector2d& corner, const Eigen::Vector2d& size);
  void end_clip();

  /// The drawing; `label` is what a screen reader says.
  Svg finish(int width_px, int height_px, const std::string& label) const;

 private:
  std::string body_;
};

/// About how wide a text of that size is in the fonts that pages use (px).
double text_width_px(std::string_view text, double size_px);

}  // namespace ballservo
