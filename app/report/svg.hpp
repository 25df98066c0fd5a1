// A finished drawing, and the colours that all drawings share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace ballservo {

/// A whole <svg> element, made by the plots and canvases of this folder only, so that a page never takes
/// loose markup.
class Svg {
 public:
  /// The element as it stands in an HTML page; texts and axes take the page's text colour.
  const std::string& markup() const { return markup_; }
  /// The contents of a file of its own (with XML's namespace, on white).
  std::string standalone() const;

  int width_px() const { return width_px_; }
  int height_px() const { return height_px_; }

 private:
  friend class SvgWriter;
  Svg(std::string body, int width_px, int height_px, const std::string& label);
  std::string markup_, body_;
  int width_px_ = 0, height_px_ = 0;
};

/// A colour of a drawing: one of the palette, the page's text colour, or 24 bits of red, green and blue.
class PlotColor {
 public:
  /// Okabe and Ito's palette ("Color universal design", 2008), told apart by colour-blind readers too, in an
  /// order in which each stands out on light and on dark paper; indices beyond it begin anew.
  static constexpr int palette_size = 7;
  static PlotColor series(int index);
  static PlotColor text() { return PlotColor{}; }
  static PlotColor rgb(std::uint8_t red, std::uint8_t green, std::uint8_t blue);

  std::string css() const;  ///< "#0072b2" or "currentColor"

 private:
  std::optional<std::uint32_t> rgb_;
};

/// How a shape is drawn. Widths are pixels of the drawing, whatever the user's coordinates are.
struct SvgStyle {
  std::optional<PlotColor> stroke = PlotColor::text();
  std::optional<PlotColor> fill;
  double width_px = 1.5;
  double opacity = 1;       ///< of stroke and fill
  double fill_opacity = 1;  ///< of the fill, on top of `opacity`
  bool dashed = false;
};

}  // namespace ballservo
