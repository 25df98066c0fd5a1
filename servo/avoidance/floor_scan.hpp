// What a frame of the camera says of the floor ahead; servo/ does not know who looked.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

namespace ballservo {

/// Along one direction over the floor, from under the camera outwards (m): floor is seen from `from_m` to
/// `clear_m`; from there to `until_m` it is not: something stands there, or hides what lies behind. Where
/// nothing stands within reach both are the reach.
struct FloorRay {
  double bearing_rad = 0;  ///< in the robot frame, left positive
  double from_m = 0, clear_m = 0, until_m = 0;
};

/// One frame's. Rays stand in the order of their bearings.
struct FloorScan {
  static constexpr std::size_t max_rays = 64;
  double time_s = -std::numeric_limits<double>::infinity();  ///< middle of the exposure, the robot's clock
  double camera_forward_m = 0;                               ///< the camera ahead of the axle
  std::array<FloorRay, max_rays> rays{};
  std::size_t count = 0;  ///< of rays; 0: nothing could be said
};

}  // namespace ballservo
