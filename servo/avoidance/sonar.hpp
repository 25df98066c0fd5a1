// The robot's sonars: where they sit, what they say, and what must not be done when a sensor is silent.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

inline constexpr std::size_t sonar_count = 16;

/// Where a transducer sits in the robot frame, and where it points (rad, from the robot's x axis).
struct SonarMount {
  double x_m = 0, y_m = 0, heading_rad = 0;

  static constexpr SonarMount at(double x_mm, double y_mm, double heading_deg) {
    return {x_mm * 1e-3, y_mm * 1e-3, heading_deg * 0.017453292519943295};
  }
};

/// Pioneer 3-DX: transducers 0 to 7 are the front array from left to right, 8 to 15 the rear array from right
/// to left.
inline constexpr std::array<SonarMount, sonar_count> pioneer_3dx_sonars{
    SonarMount::at(69, 136, 90),      SonarMount::at(114, 119, 50),    SonarMount::at(148, 78, 30),
    SonarMount::at(166, 27, 10),      SonarMount::at(166, -27, -10),   SonarMount::at(148, -78, -30),
    SonarMount::at(114, -119, -50),   SonarMount::at(69, -136, -90),   SonarMount::at(-157, -136, -90),
    SonarMount::at(-203, -119, -130), SonarMount::at(-237, -78, -150), SonarMount::at(-255, -27, -170),
    SonarMount::at(-255, 27, 170),    SonarMount::at(-237, 78, 150),   SonarMount::at(-203, 119, 130),
    SonarMount::at(-157, 136, 90)};

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

/// Where the transducer sat that fired, and where it pointed, for a robot at that pose; nothing where an
/// answer is not of this world.
std::optional<Pose2> transducer_of(const SonarReading& reading, const Pose2& robot);

/// When each sensor was last alive; -inf: never.
struct SensorStamps {
  static constexpr double never = -std::numeric_limits<double>::infinity();
  double frame_s = never;                             ///< a frame of the camera arrived
  double step_s = never;                              ///< the controller made a step
  std::array<double, 2> array_heard_s{never, never};  ///< an answer of the front, of the rear array arrived
  std::array<double, sonar_count> looked_s;           ///< a transducer fired, and its answer was believed

  SensorStamps() { looked_s.fill(never); }
};

struct GuardOptions {
  double stale_step_s = 0.1;  ///< without a step of the controller for so long: stand still
  bool sonars = true;         ///< false: the robot has none, and nothing is asked of them
};

struct GuardVerdict {
  bool stop = false;
  bool forward = true, backward = true;  ///< allowed
  std::string_view reason;               ///< of the severest; a literal, empty where all is well
};

/// A pure function of now and the stamps. Time stamps of the future and a clock that is not finite stop the
/// robot.
GuardVerdict guard(double now_s, const SensorStamps& stamps, const GuardOptions& options);

/// Listens to the sonars and keeps their stamps. Allocates nothing.
class SonarWatch {
 public:
  /// An answer that arrives now; `way` grows while the robot moves (m of its outermost corner). Returns
  /// whether it is to be believed: it is finite, of a known transducer, neither late nor from the future, and
  /// not stuck.
  bool hear(const SonarReading& reading, double now_s, double way);

  const SensorStamps& stamps() const { return stamps_; }

 private:
  struct Repeat {
    double range_m = -1, way = 0;
    int count = 0;
  };
  SensorStamps stamps_;
  std::array<Repeat, sonar_count> repeats_{};
};

}  // namespace ballservo
