// What the camera says of the floor, in the occupancy grid.
#include <algorithm>
#include <cmath>

#include "servo/avoidance/occupancy_grid.hpp"

namespace ballservo {

namespace {

constexpr double spacing_m = 0.7 * OccupancyGrid::cell_m;
constexpr unsigned lifted_every = 3;  // scans: that floor is seen where something stood is in no hurry
constexpr double depth_m = 0.5;       // of what hides the floor beyond it no more is taken to stand there

/// Every cell of a ray as wide as its part of the fan, from one range to another; some more than once.
template <typename Visit>
void along(const FloorRay& ray, double width_rad, const Eigen::Vector2d& apex, double yaw_rad, double from_m,
           double to_m, const Visit& visit) {
  if (from_m > to_m) return;
  const int lines = std::max(1, static_cast<int>(std::ceil(to_m * width_rad / spacing_m)));
  const int steps = static_cast<int>(std::ceil((to_m - from_m) / spacing_m));
  for (int line = 0; line < lines; ++line) {
    const double angle = yaw_rad + ray.bearing_rad + width_rad * ((line + 0.5) / lines - 0.5);
    const double c = std::cos(angle), s = std::sin(angle);
    for (int k = 0; k <= steps; ++k) {
      const double range_m = std::min(from_m + k * spacing_m, to_m);
      visit(OccupancyGrid::cell_at(apex.x() + range_m * c, apex.y() + range_m * s));
    }
  }
}

}  // namespace

void OccupancyGrid::look_at_floor(const FloorScan& scan, const Pose2& pose_then) {
  if (!started_ || scan.count < 2 || scan.count > FloorScan::max_rays) return;
  const Eigen::Vector2d apex = in_world_frame(pose_then, {scan.camera_forward_m, 0.0});
  const double width_rad = (scan.rays[scan.count - 1].bearing_rad - scan.rays[0].bearing_rad) /
                           static_cast<double>(scan.count - 1);
  if (!(width_rad > 0.0 && width_rad < 0.2)) return;
  ++scans_;
  for (std::size_t k = 0; k < scan.count; ++k) {
    const FloorRay& ray = scan.rays[k];
    if (!is_sane(ray)) continue;
    if (standing_cells_ > 0 && scans_ % lifted_every == 0) {
      along(ray, width_rad, apex, pose_then.yaw_rad, ray.from_m, ray.clear_m - cell_m,
            [this](const FloorCell& cell) {
              if (is_standing(cell)) set_standing(cell, false);
            });
    }
    if (ray.until_m <= ray.clear_m) continue;
    // What the scan before glimpsed too stands; this one's own glimpses do not count.
    along(ray, width_rad, apex, pose_then.yaw_rad, ray.clear_m, std::min(ray.until_m, ray.clear_m + depth_m),
          [this](const FloorCell& cell) {
            if (!in_window(cell)) return;
            std::uint32_t& glimpsed_in = glimpsed_in_[window_.index(cell)];
            if (glimpsed_in == scans_) return;
            if (glimpsed_in == scans_ - 1) {
              set_standing(cell, true);
              take_back(cell);
            }
            glimpsed_in = scans_;
          });
  }
}

}  // namespace ballservo
