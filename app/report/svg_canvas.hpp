// Free drawing in the user's own coordinates: top views, image traces, camera views.
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "app/report/svg_writer.hpp"

namespace ballservo {

struct SvgCanvasOptions {
  double x_low = 0, x_high = 1, y_low = 0, y_high = 1;  ///< what is shown, in the user's units
  int width_px = 640;            ///< of the drawing; its height follows: both axes have one scale
  bool y_down = false;           ///< true for pictures, false for maps
  bool axes = true;              ///< a frame with ticks and a light grid
  std::string x_label, y_label;  ///< with their unit: "x (m)"
  std::string title;
  /// A range that is empty or not finite is replaced by one that can be shown.
};

/// A drawing with one scale for both axes. Shapes with a value that is not finite are left out, polylines
/// broken there; what lies outside is clipped. Angles turn from x towards y, as seen in the user's
/// coordinates.
class SvgCanvas {
 public:
  explicit SvgCanvas(const SvgCanvasOptions& options);

  void polyline(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style);
  void polygon(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style);
  void circle(const Eigen::Vector2d& center, double radius, const SvgStyle& style);
  void ellipse(const Eigen::Vector2d& center, double semi_a, double semi_b, double angle_rad,
               const SvgStyle& style);
  /// A dot whose radius is pixels of the drawing.
  void dot(const Eigen::Vector2d& center, double radius_px, const PlotColor& color);
  void arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const SvgStyle& style,
             double head_px = 9);
  /// `offset_px` moves the text by pixels of the drawing (x right, y down).
  void text(const Eigen::Vector2d& at, std::string_view text, TextAnchor anchor = TextAnchor::start,
            double size_px = 12, const PlotColor& color = PlotColor::text(),
            const Eigen::Vector2d& offset_px = Eigen::Vector2d::Zero());

  /// Pixels of the drawing for one of the user's units.
  double scale() const { return scale_; }
  Svg svg() const;

 private:
  Eigen::Vector2d pixel(const Eigen::Vector2d& point) const;
  void draw_axes();

  SvgCanvasOptions options_;
  double left_ = 0, top_ = 0, width_ = 0, height_ = 0, scale_ = 1;
  int height_px_ = 0;
  SvgWriter writer_;
};

}  // namespace ballservo
