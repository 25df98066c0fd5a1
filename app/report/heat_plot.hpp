// Numbers over a picture as coloured cells, with their scale, and displacements as arrows.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "app/report/svg.hpp"
#include "calibration/base/image_size.hpp"

namespace ballservo {

/// Values at the nodes of a regular grid from border to border of a picture, row by row. What is not finite
/// stays without colour.
struct HeatPlot {
  std::string title;
  std::string unit;  ///< of the values: "mm"
  ImageSize picture;
  int columns = 0, rows = 0;
  std::vector<double> values;
  std::optional<double> high;  ///< the value of the brightest colour; the largest one where missing
  /// Displacements at the same nodes (px), drawn `arrow_scale` times as long where they stay in
  /// the picture; empty: none.
  std::vector<Eigen::Vector2d> arrows_px;
  double arrow_scale = 1;
  int width_px = 760;  ///< of the drawing
};

/// Colours from dark violet (0) to yellow (`high`). Throws std::invalid_argument where the values are not
/// columns x rows.
Svg heat_plot(const HeatPlot& plot);

/// 1, 2 or 5 times a power of ten: the largest by which arrows of that length (px) are at most `longest_px`.
double arrow_scale_for(double length_px, double longest_px);

}  // namespace ballservo
