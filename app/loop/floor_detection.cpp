#include "app/loop/floor_detection.hpp"

#include <cmath>

namespace ballservo {

FloorDetection::FloorDetection(const Camera& camera, const CameraMount& mount, double start_clear_m)
    : forward_m_(mount.forward_m), fan_(camera, mount, floor_reach_m), finder_(lay_paths(start_clear_m)) {}

FloorScan FloorDetection::look(const cv::Mat& bgr, double time_s, const std::optional<OutlineEllipse>& ball) {
  const std::vector<FloorEdge>& edges = finder_.look(bgr, ball ? &*ball : nullptr);
  FloorScan scan;
  scan.time_s = time_s;
  scan.camera_forward_m = forward_m_;
  for (std::size_t k = 0; k < edges.size(); ++k) scan.rays[scan.count++] = ray(k, edges[k]);
  return scan;
}

/// The pixels of each ray, every so many pixels, and how far out each lies.
std::vector<FloorPath> FloorDetection::lay_paths(double start_clear_m) {
  constexpr double spacing_px = 2, slack_m = 0.05;
  const double certain_m = start_clear_m - forward_m_ - slack_m;
  std::vector<FloorPath> paths;
  for (const FloorFan::Ray& ray : fan_.rays()) {
    FloorPath& path = paths.emplace_back();
    std::vector<double>& ranges_m = ranges_m_.emplace_back();
    for (double range_m = ray.from_m; range_m < fan_.reach_m();
         range_m += spacing_px * fan_.metres_per_pixel(range_m)) {
      const auto pixel = fan_.pixel(ray.bearing_rad, range_m);
      if (!pixel) continue;
      if (range_m < certain_m) ++path.certain;
      path.pixels.emplace_back(static_cast<int>(std::lround(pixel->x())),
                               static_cast<int>(std::lround(pixel->y())));
      ranges_m.push_back(range_m);
    }
  }
  return paths;
}

/// Floor is seen up to the last of its pixels.
FloorRay FloorDetection::ray(std::size_t k, const FloorEdge& edge) const {
  const std::vector<double>& range_m = ranges_m_[k];
  const FloorFan::Ray& of = fan_.rays()[k];
  FloorRay seen{of.bearing_rad, of.from_m, fan_.reach_m(), fan_.reach_m()};
  if (edge.end >= range_m.size()) return seen;
  seen.clear_m = edge.end > 0 ? range_m[edge.end - 1] : of.from_m;
  if (edge.again < range_m.size()) seen.until_m = range_m[edge.again];
  return seen;
}

}  // namespace ballservo
