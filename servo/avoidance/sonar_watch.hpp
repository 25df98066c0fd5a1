// Whether the sensors are alive: what was heard when, and what must not be done when something is silent.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include "calibration/base/fault.hpp"
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
  double stale_vision_s = 0.2;   ///< without a frame for so long: stand still
  double stale_step_s = 0.1;     ///< without a step of the controller for so long: stand still
  bool sonars = true;            ///< false: the robot has none, and nothing is asked of them
  double silent_array_s = 0.12;  ///< without an answer of an array for so long: no forward motion
  double old_look_s = 0.7;       ///< into a sector last looked at longer ago: no motion
  double late_s = 0.12;          ///< answers older than this on arrival are late, and not believed
  int stuck_after = 4;           ///< equal ranges in a row while the robot moves: stuck, and not believed

  void check(FaultList& faults, const std::string& place) const;
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
  explicit SonarWatch(const GuardOptions& options) : options_(options) {}

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
  GuardOptions options_;
  SensorStamps stamps_;
  std::array<Repeat, sonar_count> repeats_{};
  std::uint32_t stuck_ = 0, late_ = 0;
};

}  // namespace ballservo
