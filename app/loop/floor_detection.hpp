// What a picture shows of the floor ahead of the robot.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "calibration/camera/sphere_outline.hpp"
#include "perception/floor_finder.hpp"
#include "servo/avoidance/floor_scan.hpp"
#include "servo/motion/camera_mount.hpp"

namespace ballservo {

/// The floor is looked for so far ahead (m): more than the brake from the speed among obstacles, delays
/// included.
inline constexpr double floor_reach_m = 1.8;

/// Follows the floor, as it looks close to the robot, outwards along rays.
class FloorDetection {
 public:
  /// `start_clear_m`: nothing stands within it of the axle when the run begins (OccupancyGridOptions).
  FloorDetection(const Camera& camera, const CameraMount& mount, double start_clear_m);

  /// The scan of a picture taken at that time. `ball`: the target as it was seen, which stands in nobody's
  /// way.
  FloorScan look(const cv::Mat& bgr, double time_s, const std::optional<OutlineEllipse>& ball);

 private:
  std::vector<FloorPath> lay_paths(double start_clear_m);
  FloorRay ray(std::size_t k, const FloorEdge& edge) const;

  double forward_m_;
  FloorFan fan_;
  std::vector<std::vector<double>> ranges_m_;  // of each ray's pixels
  FloorFinder finder_;
};

}  // namespace ballservo
