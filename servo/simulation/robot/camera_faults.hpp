// What a camera does wrong for a while: frames that never arrive, pictures too dark or too bright.
#pragma once

#include <cstdint>
#include <vector>

#include "calibration/base/random.hpp"

namespace ballservo {

class OptionVisitor;

/// One fault, in [from_s, until_s).
struct CameraFault {
  enum class Kind { dropped, exposure };
  Kind kind = Kind::dropped;
  double from_s = 0, until_s = 3600;
  double rate = 1;          ///< dropped: share of the frames that do not arrive; 1: none arrives
  double burst_frames = 1;  ///< dropped: so many in a row, on average
  double level = 1;         ///< exposure: factor on the light that reaches the sensor

  /// The least mean burst that makes up a rate, with single frames between bursts.
  static double shortest_burst_frames(double rate) {
    return rate < 0.9999 && rate > 0.5 ? rate / (1.0 - rate) : 1.0;
  }
};

void declare(OptionVisitor& v, CameraFault& fault);

/// The faults of one run. Bursts are those of a chain of two states (E. N. Gilbert, "Capacity of a
/// burst-noise channel", Bell System Technical Journal 39(5), 1960).
class CameraFaults {
 public:
  CameraFaults(std::vector<CameraFault> faults, std::uint64_t seed);

  /// Whether the frame exposed at that time is lost; to be asked once a frame, in order.
  bool drops(double time_s);
  /// The factor on the light at that time.
  double level(double time_s) const;

  /// Whether a ball that is found in a well exposed picture is found in one of that level too. Measured on
  /// static_ball.yaml at level image (0.4 s of each level): in every frame at 0.2 to 10, for the tracker's
  /// colours follow the light; in 3 of 37 at 0.05 to 0.15.
  static bool shows_colors(double level) { return level >= 0.2; }

 private:
  struct Chain {
    RandomEngine engine;
    bool lost = false, begun = false;
  };
  std::vector<CameraFault> faults_;
  std::vector<Chain> chains_;
};

}  // namespace ballservo
