#include "app/report/svg_grid.hpp"

#include <algorithm>

#include "app/report/svg_writer.hpp"

namespace ballservo {

Svg svg_grid(const std::vector<Svg>& drawings, int columns, const std::string& label) {
  int width_px = 0, height_px = 0;
  for (const Svg& drawing : drawings) {
    width_px = std::max(width_px, drawing.width_px());
    height_px = std::max(height_px, drawing.height_px());
  }
  const int count = static_cast<int>(drawings.size()), across = std::clamp(count, 1, std::max(columns, 1));
  SvgWriter writer;
  for (int k = 0; k < count; ++k) {
    writer.drawing(Eigen::Vector2d(k % across * width_px, k / across * height_px),
                   drawings[static_cast<std::size_t>(k)]);
  }
  return writer.finish(across * width_px, (count + across - 1) / across * height_px, label);
}

}  // namespace ballservo
