// Whether the sensors are alive: what was heard when, and what must not be done when something is silent.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

#include "servo/avoidance/sonar.hpp"

namespace ballservo {

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
  /// Bit k: transducer k is stuck; its last answer was late.
  std::uint32_t stuck() const { return stuck_; }
  std::uint32_t late() const { return late_; }

 private:
  struct Repeat {
    double range_m = -1, way = 0;
    int count = 0;
  };
  SensorStamps stamps_;
  std::array<Repeat, sonar_count> repeats_{};
  std::uint32_t stuck_ = 0, late_ = 0;
};

}  // namespace ballservo
