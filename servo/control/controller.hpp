// What the robot is told, step by step, from what the camera said and where the odometry is.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "servo/avoidance/avoidance.hpp"
#include "servo/control/ball_memory.hpp"
#include "servo/control/control_states.hpp"
#include "servo/control/gaze.hpp"
#include "servo/control/law.hpp"
#include "servo/control/search.hpp"
#include "servo/motion/motion_history.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

struct ControllerOptions {
  double rate_hz = 50.0;            ///< control steps
  double latency_s = 0.033;         ///< from the middle of an exposure until its measurement arrives
  double actuation_delay_s = 0.05;  ///< from a command until it moves the robot
  double command_s = 0;  ///< a command may drive so long until the next or a rest takes over; 0: a period
  UnicycleLimits limits;
  ServoGoal goal;
  double turn_gain_per_s = 2.0;  ///< of the turn towards a ball for which the law has no answer
  AvoidanceOptions avoidance;
};
void declare(OptionVisitor& v, ControllerOptions& options);

/// What a step says.
struct ControlOutput {
  Twist2 command;        ///< always finite and within the limits
  double pan_radps = 0;  ///< the camera's speed about its pan; always finite and within the limits
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

/// One run's controller; who decides otherwise overrides `hear` and `step`. As deterministic as its law;
/// after construction it takes no memory from the heap, but for what its law takes.
class Controller {
 public:
  /// `law` drives to options.goal. Throws InputError with every fault of the options, std::invalid_argument
  /// without a law.
  Controller(const ControllerOptions& options, std::unique_ptr<Law> law);
  virtual ~Controller() = default;

  const ControllerOptions& options() const { return options_; }

  /// Law, gain, latency and avoidance.type become those, from the next step on; all else must be as it was,
  /// and what is known of ball and room stays known. Avoidance can go no further than it did at first.
  void retune(const ControllerOptions& options, std::unique_ptr<Law> law);

  /// A frame's word on the ball, which arrived at that time (else: in time for the next step, which looks at
  /// it).
  void see(const BallMeasurement& measurement, double arrived_s = std::numeric_limits<double>::infinity()) {
    ball_.see(measurement, arrived_s);
  }

  /// A sonar's answer, when it arrives; looked at in the next step. Ignored without avoidance.
  virtual void hear(const SonarReading& reading) {
    if (avoidance_) avoidance_->hear(reading);
  }

  /// What a frame showed of the floor, when it arrives. Ignored without avoidance.
  void see(const FloorScan& scan) {
    if (avoidance_) avoidance_->see(scan);
  }

  /// What the sonars have shown; null without avoidance.
  const Avoidance* avoidance() const { return avoidance_ ? &*avoidance_ : nullptr; }

  /// Where the ball is held to be at a time from the last step on, in the odometry's frame.
  std::optional<TargetEstimate> ball(double time_s) const { return ball_.predict(time_s); }

  /// Somebody else told the drive at that time to rest: the guard, on a clock of its own.
  void rested(double time_s) { note_command(time_s, {}); }

  /// What was alive when, up to the last step; the sonars' only with avoidance.
  SensorStamps stamps() const;

  /// How the camera is turned, as of the next step; 0 where nobody says it.
  void note_pan(const PanMotion& pan) { pan_ = pan; }
  const PanMotion& pan() const { return pan_; }

  /// One control step at time_s with the odometry's pose and twist of that moment. Times that are not finite
  /// or do not advance, and an odometry or a pan that is not finite, stop the robot.
  virtual ControlOutput step(double time_s, const Pose2& odometry, const Twist2& odometry_twist);

 private:
  /// The ball at the moment when a command given now acts.
  struct Target {
    Eigen::Vector2d p_RB{0, 0}, v_RB{0, 0};        // in the floor plane, in the robot frame then
    Eigen::Vector3d p_CB{0, 0, 0}, v_CB{0, 0, 0};  // in the camera frame then
    double range_error_m = 0, bearing_rad = 0;
    double scale = 1;  // as in TargetEstimate
  };
  /// What the state asks for: a command, or a way through obstacles to a place.
  struct Wish {
    Twist2 command;
    std::optional<SteeringInput> way;
  };

  std::optional<Target> predict_target(double time_s, const RobotMotion& when_it_acts) const;
  std::optional<LawOutput> ask_law(const Target& target) const;
  Findings look_around(double time_s, const RobotMotion& now, const RobotMotion& when_it_acts,
                       const std::optional<Target>& target);
  void react(const Findings& findings, double time_s, const Pose2& pose);
  Wish wanted(double time_s, const Pose2& pose, const RobotMotion& when_it_acts,
              const std::optional<Target>& target, const std::optional<LawOutput>& law) const;
  Twist2 by_law(const Target& target, const Twist2& twist, const std::optional<LawOutput>& law) const;
  double pan_speed(double time_s, const std::optional<Target>& target, const Twist2& twist);
  Twist2 steered(const SteeringInput& way);
  Twist2 driven(double time_s) const;
  Twist2 within_limits(double time_s, const Twist2& wanted, const Pose2& pose);
  bool is_cautious() const { return avoidance_ && options_.avoidance.type != AvoidanceOptions::Type::none; }
  bool steers() const {
    return avoidance_ && avoidance_->steers() && options_.avoidance.type == AvoidanceOptions::Type::full;
  }
  void note_command(double time_s, const Twist2& command);

  ControllerOptions options_;
  std::unique_ptr<Law> law_;
  std::optional<Avoidance> avoidance_;
  PoseHistory poses_;
  MotionPredictor predictor_;
  PanMotion pan_;
  Gaze gaze_;
  Twist2 last_command_, drive_;  // and how the drive turned the wheels when it was given
  double commanded_s_ = 0;
  BallMemory ball_;
  Search search_;
  ControlStates states_;
  double step_time_s_ = -std::numeric_limits<double>::infinity();  // of the last step
};

}  // namespace ballservo
