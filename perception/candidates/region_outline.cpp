#include "perception/candidates/region_outline.hpp"

#include "perception/candidates/region_shape.hpp"

namespace ballservo {
namespace {

constexpr std::size_t max_points = 256;

}  // namespace

const RegionOutline& OutlineTracer::trace(const RegionMap& regions, int region_index, const cv::Point& window,
                                          const RayTable& rays) {
  auto& [points, pixels] = outline_;
  const Region& region = regions.regions()[static_cast<std::size_t>(region_index)];
  const BitPicture& colored = regions.pixels_of(region.color_class);
  regions.boundary(region_index, boundary_);
  chain_.order(boundary_, colored.size());
  const std::size_t stride = (boundary_.size() + max_points - 1) / max_points;
  outline_.clear();
  for (std::size_t i = 0; i < boundary_.size(); i += stride) {
    const BoundaryPixel& pixel = boundary_[i];
    const auto position = rays.undistorted_px(pixel.u_px + window.x, pixel.v_px + window.y);
    if (!position) continue;
    points.push_back({*position, {0, 0}});
    pixels.push_back(pixel);
  }
  // The picture's border cuts every shape.
  if (!region.touches_border &&
      is_no_balls(region_shape(pixels, points, region.pixels, rays.camera().focal_px()))) {
    outline_.clear();
    return outline_;
  }
  const std::vector<char>& straight = sides_.find(points);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (straight[i]) continue;
    const BoundaryPixel pixel = pixels[i];
    const Eigen::Vector2f outward = outward_normal(colored, pixel);
    points[kept] = {points[i].position_px + 0.5f * outward, outward};
    pixels[kept++] = {pixel.u_px + window.x, pixel.v_px + window.y, outward};
  }
  outline_.resize(kept);
  return outline_;
}

}  // namespace ballservo
