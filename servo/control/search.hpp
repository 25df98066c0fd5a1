// How the robot looks for a ball that is not in the picture: by turns on the spot, and from other places.
#pragma once

#include <Eigen/Core>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

/// A search is a turn on the spot, first a little to one side, then all around the other way; then, where
/// ways among obstacles are looked for, an excursion to another place and a turn there, up to
/// `most_excursions` times. Where the robot cannot turn on, it turns the other way round. Deterministic;
/// allocates nothing.
class Search {
 public:
  static constexpr double look_s = 0.4;       ///< standing and looking, before the robot turns
  static constexpr double pass_over_s = 0.6;  ///< and turning, before what was passed over counts again
  static constexpr int most_excursions = 12;

  /// A run begins there.
  void start(double time_s, const Pose2& pose);

  /// Which side the ball was seen on last; the next turn goes there.
  void note_ball(double bearing_rad) { sign_ = bearing_rad < 0.0 ? -1.0 : 1.0; }
  /// Every control step: where the robot looks now, and whether it has been searching since the step before.
  void note_heading(double yaw_rad, bool searching);

  /// A turn begins: with a look ahead, or where one was broken off.
  void begin_turn(double time_s);
  void resume_turn(double time_s) { turn_since_s_ = turning_s_ = time_s; }
  /// What was seen was not confirmed: half out of the picture, perhaps. The turn goes on towards it, and for
  /// a while sights do not stop it.
  void pass_over(double time_s) {
    resume_turn(time_s);
    passed_over_s_ = time_s;
  }
  bool passes_over(double time_s) const { return time_s - passed_over_s_ < look_s + pass_over_s; }
  /// To the left the turn shows what was not seen yet so many times sooner than to the right. It goes there;
  /// once it may turn back.
  void prefer(double sooner_left);
  /// A step of the turn at the robot's twist; true when it has shown all that it can.
  bool turn(double time_s, const Twist2& twist);
  /// What the turn asks of the drive.
  Twist2 turn_command(double time_s) const;

  /// Whether it has left the place where it began.
  bool has_set_out() const { return excursions_ > 0; }
  /// Whether there may be another excursion.
  bool may_set_out() const { return excursions_ < most_excursions; }
  /// To that place, or, where it is no excursion from `pose`, to where the run began.
  void set_out(double time_s, const Pose2& pose, const Eigen::Vector2d& p_O);
  const Eigen::Vector2d& destination() const { return p_OD_; }
  /// There, but for the way that the brake takes.
  bool arrives(const Pose2& pose, const Twist2& twist, double a_max_mps2) const;
  bool out_of_time(double time_s) const;
  /// There is no way to where it leads.
  void end_excursion() { excursion_since_s_ = -1e9; }
  /// The ball was found: as if there had been none.
  void forget_excursions() { excursions_ = 0; }

  /// The ball went out of sight: it is expected where it was last.
  void expect_ball(double time_s) { expected_s_ = time_s; }
  /// Whether it has been looked for long enough there; `in_view`: it should be in the picture now.
  bool misses_ball(double time_s, bool in_view);

 private:
  /// Before it turns.
  bool looks(double time_s) const;

  Pose2 start_;
  double sign_ = 1;                           // of the turn, counter-clockwise positive
  double turned_rad_ = 0, last_yaw_rad_ = 0;  // in this turn; at the step before
  double turn_since_s_ = 0, turning_s_ = 0;   // when it began; when the robot last turned
  double passed_over_s_ = -1e9;               // when what was seen was last passed over
  int flips_ = 0;                             // because the robot could not turn on
  bool looked_aside_ = false, turned_back_ = false;
  int excursions_ = 0;
  Eigen::Vector2d p_OD_{0, 0};
  double excursion_since_s_ = 0, expected_s_ = 0;
};

}  // namespace ballservo
