// What the controller knows of the ball: the frames that have arrived, and the filter behind them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "servo/control/ball_measurement.hpp"
#include "servo/control/target_filter.hpp"
#include "servo/motion/pose_history.hpp"

namespace ballservo {

/// Frames wait in an inbox until a control step takes them in. Allocates nothing.
class BallMemory {
 public:
  explicit BallMemory(const CameraMount& mount) : filter_(mount) {}

  /// A frame that arrived at that time.
  void see(const BallMeasurement& measurement, double arrived_s);
  /// The first frame is awaited from here on.
  void start(double time_s) { frame_s_ = frame_arrived_s_ = time_s; }
  /// Reads the inbox; duplicate frames, backward ones and those of the future are left out.
  void take_in(double time_s, const PoseHistory& poses);
  void clear_inbox() { inbox_count_ = 0; }
  /// The track is to be confirmed anew.
  void doubt() { confirmed_ = 0; }

  /// Where the ball is at time_s; a ball out of sight is not taken to move on for ever. Nothing before the
  /// first sighting.
  std::optional<TargetEstimate> predict(double time_s) const;

  /// Whether something that is not finite was taken in last.
  bool nonsense() const { return nonsense_; }
  double frame_s() const { return frame_s_; }                  ///< exposure of the newest frame
  double frame_arrived_s() const { return frame_arrived_s_; }  ///< when it arrived
  double sighting_s() const { return sighting_s_; }        ///< exposure of the newest sighting; -inf: none
  int confirmed() const { return confirmed_; }             ///< confirmed sightings in a row
  TrackState track_state() const { return track_state_; }  ///< of the newest frame

 private:
  static constexpr double never = -std::numeric_limits<double>::infinity();
  struct Arrival {
    BallMeasurement frame;
    double arrived_s = 0;
  };

  TargetFilter filter_;
  std::array<Arrival, 16> inbox_;
  std::size_t inbox_count_ = 0;
  double frame_s_ = never, frame_arrived_s_ = never, sighting_s_ = never;
  TrackState track_state_ = TrackState::none;
  int confirmed_ = 0;
  bool nonsense_ = false;
};

}  // namespace ballservo
