#include "app/report/svg_canvas.hpp"

#include <algorithm>
#include <cmath>

#include "app/report/ticks.hpp"

namespace ballservo {
namespace {

void make_showable(double& low, double& high) {
  if (!showable(low, false) || !showable(high, false) || !(high > low)) {
    const AxisRange range = range_of({low, high}, false);
    low = range.low;
    high = range.high;
  }
}

}  // namespace

SvgCanvas::SvgCanvas(const SvgCanvasOptions& options) : options_(options) {
  make_showable(options_.x_low, options_.x_high);
  make_showable(options_.y_low, options_.y_high);
  options_.width_px = std::clamp(options_.width_px, 120, 4000);
  const bool axes = options_.axes;
  left_ = axes ? 44 + (options_.y_label.empty() ? 0 : 18) : 0;
  top_ = (options_.title.empty() ? 0 : 24) + (axes ? 8 : 0);
  width_ = options_.width_px - left_ - (axes ? 12 : 0);
  scale_ = width_ / (options_.x_high - options_.x_low);
  height_ = scale_ * (options_.y_high - options_.y_low);
  // A very tall or flat world would make a useless drawing: show more of the other axis instead.
  const double tallest = 2.5 * width_, flattest = 0.15 * width_;
  if (height_ > tallest) {
    scale_ = tallest / (options_.y_high - options_.y_low);
    const double middle = (options_.x_low + options_.x_high) / 2;
    options_.x_low = middle - width_ / scale_ / 2;
    options_.x_high = middle + width_ / scale_ / 2;
    height_ = tallest;
  } else if (height_ < flattest) {
    const double middle = (options_.y_low + options_.y_high) / 2;
    options_.y_low = middle - flattest / scale_ / 2;
    options_.y_high = middle + flattest / scale_ / 2;
    height_ = flattest;
  }
  height_px_ =
      static_cast<int>(std::ceil(top_ + height_ + (axes ? 26 + (options_.x_label.empty() ? 0 : 20) : 0)));
  if (!options_.title.empty()) {
    writer_.text({options_.width_px / 2.0, 17}, options_.title, TextAnchor::middle, 14, true);
  }
  if (axes) draw_axes();
  writer_.begin_clip({left_, top_}, {width_, height_});
}

Eigen::Vector2d SvgCanvas::pixel(const Eigen::Vector2d& point) const {
  const double down = options_.y_down ? point.y() - options_.y_low : options_.y_high - point.y();
  return {left_ + scale_ * (point.x() - options_.x_low), top_ + scale_ * down};
}

void SvgCanvas::draw_axes() {
  SvgStyle grid;
  grid.width_px = 1;
  grid.opacity = 0.13;
  const double bottom = top_ + height_, right = left_ + width_;
  for (const Tick& tick :
       linear_ticks(options_.x_low, options_.x_high, std::max(2, static_cast<int>(width_ / 70)))) {
    const double x = pixel({tick.value, options_.y_low}).x();
    writer_.line({x, top_}, {x, bottom}, grid);
    writer_.text({x, bottom + 16}, tick.label, TextAnchor::middle, 11);
  }
  for (const Tick& tick :
       linear_ticks(options_.y_low, options_.y_high, std::max(2, static_cast<int>(height_ / 50)))) {
    const double y = pixel({options_.x_low, tick.value}).y();
    writer_.line({left_, y}, {right, y}, grid);
    writer_.text({left_ - 6, y + 4}, tick.label, TextAnchor::end, 11);
  }
  SvgStyle frame;
  frame.width_px = 1;
  frame.opacity = 0.6;
  writer_.rectangle({left_, top_}, {width_, height_}, frame);
  writer_.text({left_ + width_ / 2, bottom + 36}, options_.x_label, TextAnchor::middle, 12);
  writer_.text({14, top_ + height_ / 2}, options_.y_label, TextAnchor::middle, 12, false, true);
}

void SvgCanvas::polyline(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style) {
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(points.size());
  for (const Eigen::Vector2d& point : points) pixels.push_back(pixel(point));
  writer_.polyline(pixels, style);
}

void SvgCanvas::polygon(const std::vector<Eigen::Vector2d>& points, const SvgStyle& style) {
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(points.size());
  for (const Eigen::Vector2d& point : points) pixels.push_back(pixel(point));
  writer_.polygon(pixels, style);
}

void SvgCanvas::circle(const Eigen::Vector2d& center, double radius, const SvgStyle& style) {
  writer_.ellipse(pixel(center), scale_ * radius, scale_ * radius, 0, style);
}

void SvgCanvas::ellipse(const Eigen::Vector2d& center, double semi_a, double semi_b, double angle_rad,
                        const SvgStyle& style) {
  writer_.ellipse(pixel(center), scale_ * semi_a, scale_ * semi_b, options_.y_down ? angle_rad : -angle_rad,
                  style);
}

void SvgCanvas::dot(const Eigen::Vector2d& center, double radius_px, const PlotColor& color) {
  SvgStyle style;
  style.stroke.reset();
  style.fill = color;
  writer_.ellipse(pixel(center), radius_px, radius_px, 0, style);
}

void SvgCanvas::arrow(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const SvgStyle& style,
                      double head_px) {
  writer_.arrow(pixel(from), pixel(to), head_px, style);
}

void SvgCanvas::text(const Eigen::Vector2d& at, std::string_view text, TextAnchor anchor, double size_px,
                     const PlotColor& color, const Eigen::Vector2d& offset_px) {
  writer_.text(pixel(at) + offset_px, text, anchor, size_px, false, false, color);
}

Svg SvgCanvas::svg() const {
  SvgWriter closed = writer_;
  closed.end_clip();
  return closed.finish(options_.width_px, height_px_, options_.title.empty() ? "drawing" : options_.title);
}

}  // namespace ballservo
