// The robot's sonars: where they sit, and what they say.
#pragma once

#include <array>
#include <cstddef>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

inline constexpr std::size_t sonar_count = 16;

/// Where a transducer sits in the robot frame, and where it points (rad, from the robot's x axis).
struct SonarMount {
  double x_m = 0, y_m = 0, heading_rad = 0;
};

namespace detail {
constexpr SonarMount sonar_at(double x_mm, double y_mm, double heading_deg) {
  return {x_mm * 1e-3, y_mm * 1e-3, heading_deg * 0.017453292519943295};
}
}  // namespace detail

/// Pioneer 3-DX: transducers 0 to 7 are the front array from left to right, 8 to 15 the rear array from right
/// to left.
inline constexpr std::array<SonarMount, sonar_count> pioneer_3dx_sonars{
    detail::sonar_at(69, 136, 90),      detail::sonar_at(114, 119, 50),    detail::sonar_at(148, 78, 30),
    detail::sonar_at(166, 27, 10),      detail::sonar_at(166, -27, -10),   detail::sonar_at(148, -78, -30),
    detail::sonar_at(114, -119, -50),   detail::sonar_at(69, -136, -90),   detail::sonar_at(-157, -136, -90),
    detail::sonar_at(-203, -119, -130), detail::sonar_at(-237, -78, -150), detail::sonar_at(-255, -27, -170),
    detail::sonar_at(-255, 27, 170),    detail::sonar_at(-237, 78, 150),   detail::sonar_at(-203, 119, 130),
    detail::sonar_at(-157, 136, 90)};

/// What every transducer of the ring can do, as its data sheet says.
struct SonarBeam {
  double min_range_m = 0.10, max_range_m = 5.0;
  double half_angle_rad = 15.0 * 0.017453292519943295;  ///< of the cone in which things echo
};
void declare(OptionVisitor& v, SonarBeam& beam);

/// One firing's answer.
struct SonarReading {
  double fired_s = 0;          ///< on the robot's clock
  std::size_t transducer = 0;  ///< 0 to 15
  double range_m = 0;          ///< to the nearest echo; the maximum range where there is none
  bool echo = false;
};

}  // namespace ballservo
