// The control loop: what the robot is told, step by step, from what the camera said and where the odometry
// is.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "servo/avoidance/avoidance.hpp"
#include "servo/control/ball_measurement.hpp"
#include "servo/control/law.hpp"
#include "servo/control/target_filter.hpp"
#include "servo/motion/motion_predictor.hpp"
#include "servo/motion/pose_history.hpp"
#include "servo/motion/speed_envelope.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

struct ControllerOptions {
  double rate_hz = 50.0;            ///< control steps
  double latency_s = 0.033;         ///< from the middle of an exposure until its measurement arrives
  double actuation_delay_s = 0.05;  ///< from a command until it moves the robot
  double command_s = 0;  ///< a command may drive so long until the next or a rest takes over; 0: a period
  UnicycleLimits limits;
  ServoGoal goal;
  double turn_gain_per_s = 2.0;  ///< of the turn towards a ball for which the law has no answer
  EnvelopeOptions envelope;
  TargetFilterOptions filter;
  AvoidanceOptions avoidance;

  int sightings_to_trust = 3;       ///< confirmed ones, before the robot drives on them
  double acquire_s = 0.5;           ///< a sighting that is not confirmed within it is let go
  double coast_s = 0.6;             ///< the robot drives on the prediction so long without a sighting
  double stale_s = 0.2;             ///< without a frame (beyond the latency) for so long, the robot stops
  double look_s = 0.4;              ///< standing still and looking, before a search begins to turn
  double search_speed_radps = 0.7;  ///< of the turn on the spot
  double search_aside_rad = 0.6;    ///< the first search turns so far to one side, then the other way round
  double search_turn_rad = 6.8;     ///< a search that has turned so far on without the ball has ended
  int excursions = 5;               ///< to other places to look from, with avoidance, before a search ends
  double excursion_m = 1.8;         ///< at most so far each
  double excursion_s = 10.0;        ///< and for so long
  double remember_s = 30.0;         ///< a ball out of sight is driven to for so long, with avoidance
  double extrapolate_s = 1.5;       ///< it is taken to go on moving for so long
  double turn_first_rad = 1.05;     ///< a ball further to the side is turned to before the law drives
  double hold_range_m = 0.0004;     ///< both errors below these: arrived, stand still
  double hold_bearing_rad = 0.0004;
  double resume_range_m = 0.0025;  ///< either error above these: correct
  double resume_bearing_rad = 0.0025;

  void check(FaultList& faults, const std::string& place) const;
};

/// search: no ball yet, look and then turn. explore: not found by turning, drive to another place and look
/// from there. acquire: seen, stand until it is confirmed. approach: the law drives, around obstacles where
/// there are any. hold: arrived, stand. reacquire: out of sight, drive to where it was last. blocked: no way
/// on, look around and back up. lost: stop, and say so. given_up: a search has ended without the ball. stale:
/// no frames, stop. fault: something that is not finite came in, stop.
enum class ControlState {
  search,
  explore,
  acquire,
  approach,
  hold,
  reacquire,
  blocked,
  lost,
  given_up,
  stale,
  fault
};
std::string_view control_state_name(ControlState state);

/// What a step says.
struct ControlOutput {
  Twist2 command;  ///< always finite and within the limits
  ControlState state = ControlState::search;
  std::string_view reason;                    ///< why this state; a literal
  TrackState track_state = TrackState::none;  ///< of the newest frame
  double error_1 =
      std::numeric_limits<double>::quiet_NaN();  ///< the law's, as predicted for when the command acts
  double error_2 = std::numeric_limits<double>::quiet_NaN();
  int lost_events = 0;      ///< so far
  Twist2 intended;          ///< what was to be told to the drive before guard and shield looked at it
  std::string_view shield;  ///< what they did to it; a literal, empty where it passed
};

/// One run's controller. As deterministic as its law; after construction it takes no memory from the heap,
/// but for what its law takes.
class Controller {
 public:
  /// `law` drives to options.goal. Throws InputError with every fault of the options, std::invalid_argument
  /// without a law.
  Controller(const ControllerOptions& options, std::unique_ptr<Law> law);

  const ControllerOptions& options() const { return options_; }

  /// A frame's word on the ball, which arrived at that time (else: in time for the next step, which looks at
  /// it).
  void see(const BallMeasurement& measurement, double arrived_s = std::numeric_limits<double>::infinity());

  /// A sonar's answer, when it arrives; looked at in the next step. Ignored without avoidance.
  void hear(const SonarReading& reading) {
    if (avoidance_) avoidance_->hear(reading);
  }

  /// What a frame showed of the floor, when it arrives. Ignored without avoidance.
  void see(const FloorScan& scan) {
    if (avoidance_) avoidance_->see(scan);
  }

  /// What the sonars have shown; null without avoidance.
  const Avoidance* avoidance() const { return avoidance_ ? &*avoidance_ : nullptr; }

  /// Somebody else told the drive at that time to rest: the guard, on a clock of its own.
  void rested(double time_s);

  /// What was alive when, up to the last step; the sonars' only with avoidance.
  SensorStamps stamps() const;

  /// One control step at time_s with the odometry's pose and twist of that moment. Times that are not finite
  /// or do not advance, and an odometry that is not finite, stop the robot.
  ControlOutput step(double time_s, const Pose2& odometry, const Twist2& odometry_twist);

 private:
  struct Target;  // the ball as it will be when the command acts
  void take_in(double time_s);
  bool predict_target(double time_s, const RobotMotion& when_it_acts, Target& target) const;
  void lose(std::string_view reason, double time_s);
  void search_on(double time_s, const Pose2& odometry);
  void follow(double time_s, bool seen, bool trusted, const Target* target);
  void remember(double time_s, bool just_seen, const Target* target);
  bool excursion_ends(double time_s, const Pose2& odometry, const Twist2& twist) const;
  void update_state(double time_s, const Pose2& odometry, const Twist2& twist, const Target* target);
  Twist2 wanted(const Target* target, const RobotMotion& when_it_acts, LawOutput* law_output);
  Twist2 by_law(const Target& target, const std::optional<LawOutput>& law) const;
  Twist2 steered(const Eigen::Vector2d& p_OB, double distance_m, const std::optional<Twist2>& law,
                 const RobotMotion& when_it_acts);
  bool steers() const { return avoidance_ && avoidance_->steers(); }
  void finish(double time_s, const Twist2& wanted, const RobotMotion& when_it_acts, ControlOutput& output);
  void enter(ControlState state, std::string_view reason, double time_s);

  ControllerOptions options_;
  std::unique_ptr<Law> law_;
  TargetFilter filter_;
  PoseHistory poses_;
  MotionPredictor predictor_;
  double goal_range_m_ = 0, goal_bearing_rad_ = 0;  // of the ball at the goal, as the robot believes
  std::optional<Avoidance> avoidance_;

  static constexpr std::size_t inbox_size_ = 16;
  struct Arrival {
    BallMeasurement frame;
    double arrived_s = 0;
  };
  std::array<Arrival, inbox_size_> inbox_;
  std::size_t inbox_count_ = 0;

  ControlState state_ = ControlState::search;
  std::string_view reason_ = "start: looking for the ball";
  double state_since_s_ = 0, step_time_s_, frame_time_s_, sighting_time_s_;
  double frame_arrived_s_;  // the newest
  TrackState track_state_ = TrackState::none;
  int confirmed_ = 0, lost_events_ = 0;
  bool bad_measurement_ = false, started_ = false, had_ball_ = false, looked_aside_ = false;
  double turned_rad_ = 0, last_yaw_rad_ = 0, search_sign_ = 1;
  Twist2 last_command_;
  int excursions_ = 0, search_flips_ = 0;
  double turning_s_ = 0;  // when the search last turned
  double start_yaw_rad_ = 0;
  Eigen::Vector2d excursion_to_{0, 0}, start_O_{0, 0};
  double excursion_since_s_ = 0;
  double sought_since_s_ = 0;  // at the remembered place, looking for the ball
  ControlState before_blocked_ = ControlState::approach;
  Pose2 odometry_;
};

}  // namespace ballservo
