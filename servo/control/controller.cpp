#include "servo/control/controller.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "calibration/base/options.hpp"
#include "servo/control/controller_target.hpp"
#include "servo/motion/option_check.hpp"

namespace ballservo {

namespace {

constexpr double never = -std::numeric_limits<double>::infinity();

bool finite(const Pose2& pose) {
  // Beyond these a pose is as good as not finite: differences would lose the millimetres.
  return std::abs(pose.x_m) < 1e6 && std::abs(pose.y_m) < 1e6 && std::abs(pose.yaw_rad) < 1e6;
}
bool finite(const Twist2& twist) { return std::abs(twist.v_mps) < 1e3 && std::abs(twist.w_radps) < 1e3; }

std::size_t history_length(double rate_hz) { return static_cast<std::size_t>(std::ceil(5.0 * rate_hz)) + 8; }

const ControllerOptions& checked(const ControllerOptions& options) {
  FaultList faults;
  options.check(faults, "controller");
  faults.throw_if_any();
  return options;
}

}  // namespace

void ControllerOptions::check(FaultList& faults, const std::string& place) const {
  if (!(rate_hz > 0.0 && rate_hz <= 10000.0)) {
    faults.add(place + ".rate_hz", shown_number(rate_hz), "a number above 0 and up to 10000 (Hz)");
  }
  if (!(latency_s >= 0.0 && latency_s <= 2.0)) {
    faults.add(place + ".latency_s", shown_number(latency_s), "a number from 0 to 2 (s)");
  }
  if (!(actuation_delay_s >= 0.0 && actuation_delay_s <= 2.0)) {
    faults.add(place + ".actuation_delay_s", shown_number(actuation_delay_s), "a number from 0 to 2 (s)");
  }
  check_options(faults, place + ".limits", limits);
  check_not_negative(faults, place + ".command_s", command_s, "s");
  check_options(faults, place + ".goal", goal);
  check_positive(faults, place + ".turn_gain_per_s", turn_gain_per_s, "1/s");
  envelope.check(faults, place + ".envelope");
  filter.check(faults, place + ".filter");
  avoidance.check(faults, place + ".avoidance");
  if (sightings_to_trust < 1) {
    faults.add(place + ".sightings_to_trust", std::to_string(sightings_to_trust), "1 or more");
  }
  check_positive(faults, place + ".acquire_s", acquire_s, "s");
  check_not_negative(faults, place + ".coast_s", coast_s, "s");
  check_positive(faults, place + ".stale_s", stale_s, "s");
  check_not_negative(faults, place + ".look_s", look_s, "s");
  check_positive(faults, place + ".search_speed_radps", search_speed_radps, "rad/s");
  check_not_negative(faults, place + ".search_aside_rad", search_aside_rad, "rad");
  check_not_negative(faults, place + ".search_turn_rad", search_turn_rad, "rad");
  if (excursions < 0) faults.add(place + ".excursions", std::to_string(excursions), "0 or more");
  check_positive(faults, place + ".excursion_m", excursion_m, "m");
  check_positive(faults, place + ".excursion_s", excursion_s, "s");
  check_not_negative(faults, place + ".remember_s", remember_s, "s");
  check_not_negative(faults, place + ".extrapolate_s", extrapolate_s, "s");
  check_positive(faults, place + ".turn_first_rad", turn_first_rad, "rad");
  check_positive(faults, place + ".hold_range_m", hold_range_m, "m");
  check_positive(faults, place + ".hold_bearing_rad", hold_bearing_rad, "rad");
  if (!(resume_range_m > hold_range_m)) {
    faults.add(place + ".resume_range_m", shown_number(resume_range_m), "more than hold_range_m (m)");
  }
  if (!(resume_bearing_rad > hold_bearing_rad)) {
    faults.add(place + ".resume_bearing_rad", shown_number(resume_bearing_rad),
               "more than hold_bearing_rad (rad)");
  }
}

Controller::Controller(const ControllerOptions& options, std::unique_ptr<Law> law)
    : options_(checked(options)),
      law_(std::move(law)),
      filter_(options.filter, options.goal.mount),
      poses_(history_length(options.rate_hz)),
      predictor_(options.limits, options.actuation_delay_s, history_length(options.rate_hz)),
      step_time_s_(never),
      frame_time_s_(never),
      sighting_time_s_(never),
      frame_arrived_s_(never) {
  if (!law_) throw std::invalid_argument("a Controller needs a law");
  const Eigen::Vector3d p_RB = options.goal.desired_p_RB();
  goal_range_m_ = std::hypot(p_RB.x(), p_RB.y());
  goal_bearing_rad_ = std::atan2(p_RB.y(), p_RB.x());
  if (options.avoidance.type != AvoidanceOptions::Type::none) {
    const double command_s = options.command_s > 0.0 ? options.command_s : 1.0 / options.rate_hz;
    avoidance_.emplace(options.avoidance, options.limits, command_s);
  }
}

void Controller::see(const BallMeasurement& measurement, double arrived_s) {
  if (inbox_count_ == inbox_size_) {  // more frames than steps can read: the oldest goes
    std::move(inbox_.begin() + 1, inbox_.end(), inbox_.begin());
    --inbox_count_;
  }
  inbox_[inbox_count_++] = {measurement, arrived_s};
}

void Controller::rested(double time_s) {
  last_command_ = {};
  predictor_.add_command(time_s, {});
}

SensorStamps Controller::stamps() const {
  SensorStamps stamps = avoidance_ ? avoidance_->watch().stamps() : SensorStamps{};
  stamps.frame_s = frame_arrived_s_;
  stamps.step_s = step_time_s_;
  return stamps;
}

// The whole loop: look, predict, decide, drive, keep within what the robot can do.
ControlOutput Controller::step(double time_s, const Pose2& odometry, const Twist2& odometry_twist) {
  ControlOutput output;
  const bool sane =
      std::isfinite(time_s) && time_s > step_time_s_ && finite(odometry) && finite(odometry_twist);
  if (!sane) {
    enter(ControlState::fault, "time or odometry is not finite or does not advance", step_time_s_);
    inbox_count_ = 0;
  } else {
    if (!started_) {
      started_ = true;
      // The first frame is awaited from here on.
      state_since_s_ = frame_time_s_ = frame_arrived_s_ = time_s;
      last_yaw_rad_ = start_yaw_rad_ = odometry.yaw_rad;
      start_O_ = {odometry.x_m, odometry.y_m};
    }
    step_time_s_ = time_s;
    odometry_ = odometry;
    poses_.add(time_s, odometry);
    take_in(time_s);
    if (avoidance_) avoidance_->update(time_s, odometry, poses_);
    const RobotMotion when_it_acts = predictor_.predict(time_s, {odometry, odometry_twist});

    Target target;
    const bool known = predict_target(time_s, when_it_acts, target);
    update_state(time_s, odometry, odometry_twist, known ? &target : nullptr);

    LawOutput law_output{{}, output.error_1, output.error_2};
    finish(time_s, wanted(known ? &target : nullptr, when_it_acts, &law_output), when_it_acts, output);
    output.error_1 = law_output.error_1;
    output.error_2 = law_output.error_2;
  }
  if (!sane) {
    last_command_ = {};
    if (std::isfinite(step_time_s_)) predictor_.add_command(step_time_s_, {});
  }
  output.state = state_;
  output.reason = reason_;
  output.track_state = track_state_;
  output.lost_events = lost_events_;
  return output;
}

/// Reads the frames that have arrived since the last step.
void Controller::take_in(double time_s) {
  bad_measurement_ = false;
  for (std::size_t i = 0; i < inbox_count_; ++i) {
    const BallMeasurement& frame = inbox_[i].frame;
    const bool claims_ball = frame.state != TrackState::none;
    if (!std::isfinite(frame.time_s) ||
        (claims_ball && (!frame.p_CB.allFinite() || !frame.covariance_m2.allFinite()))) {
      bad_measurement_ = true;
      continue;
    }
    if (frame.time_s <= frame_time_s_ || frame.time_s > time_s)
      continue;  // duplicate, backward or from the future
    frame_time_s_ = frame.time_s;
    frame_arrived_s_ = std::min(inbox_[i].arrived_s, time_s);
    if (avoidance_) avoidance_->see_frame(frame_arrived_s_);
    track_state_ = frame.state;
    if (!frame.is_sighting()) continue;
    const auto pose = poses_.at(frame.time_s);
    if (!pose) continue;  // older than all that is remembered
    const TargetFilter::Update update = filter_.update(frame, *pose);
    if (update == TargetFilter::Update::ignored || update == TargetFilter::Update::doubted) continue;
    if (update == TargetFilter::Update::started) confirmed_ = 0;
    sighting_time_s_ = frame.time_s;
    confirmed_ = frame.state == TrackState::confirmed ? confirmed_ + 1 : 0;
  }
  inbox_count_ = 0;
}

/// The ball relative to the robot at the moment when a command given now acts; false if it is not known.
bool Controller::predict_target(double time_s, const RobotMotion& when_it_acts, Target& target) const {
  // What is out of sight is not taken to move on for ever.
  const double until_s = filter_.last_time_s() + options_.extrapolate_s;
  const double when_s = time_s + options_.actuation_delay_s;
  auto estimate = filter_.predict(std::min(when_s, until_s));
  if (!estimate) return false;
  if (when_s > until_s) estimate->v_OB.setZero();
  target.robot = when_it_acts;
  const Eigen::Isometry3d X_RO = X_WR(target.robot.pose).inverse();
  const Eigen::Isometry3d X_CR = options_.goal.mount.X_RC().inverse();
  const Eigen::Vector3d p_RB = X_RO * estimate->p_OB;
  const Eigen::Vector3d v_RB = X_RO.linear() * Eigen::Vector3d(estimate->v_OB.x(), estimate->v_OB.y(), 0.0);
  target.p_RB = p_RB.head<2>();
  target.v_RB = v_RB.head<2>();
  target.p_CB = X_CR * p_RB;
  target.v_CB = X_CR.linear() * v_RB;
  target.range_error_m = target.p_RB.norm() - goal_range_m_;
  target.bearing_rad = wrap_angle(std::atan2(target.p_RB.y(), target.p_RB.x()) - goal_bearing_rad_);
  return std::isfinite(target.range_error_m) && std::isfinite(target.bearing_rad);
}

/// The law's command within the envelope that braking allows.
Twist2 Controller::by_law(const Target& target, const std::optional<LawOutput>& law) const {
  // The distance that the robot still covers before this command's own period is over.
  const double e = target.range_error_m;
  const double covered_m = target.robot.twist.v_mps / options_.rate_hz;
  const double left_m =
      e > 0.0 ? std::max(0.0, e - std::max(0.0, covered_m)) : std::min(0.0, e - std::min(0.0, covered_m));
  Twist2 command;
  if (law && std::abs(target.bearing_rad) <= options_.turn_first_rad) {
    command = law->twist;
  } else {
    command.w_radps = options_.turn_gain_per_s * target.bearing_rad;
  }
  return limit_to_envelope(command, left_m, target.p_RB, target.v_RB, options_.limits, options_.envelope);
}

/// The way to a place among obstacles; tells the state machine where there is none.
Twist2 Controller::steered(const Eigen::Vector2d& p_OB, double distance_m, const std::optional<Twist2>& law,
                           const RobotMotion& when_it_acts) {
  const SteeringOutput output =
      avoidance_->steer({step_time_s_, odometry_, when_it_acts, p_OB, distance_m, law});
  if (output.stuck && state_ != ControlState::blocked) {
    before_blocked_ = state_;
    enter(ControlState::blocked, output.reason, step_time_s_);
  } else if (!output.stuck && state_ == ControlState::blocked) {
    enter(before_blocked_, "going on", step_time_s_);
  } else {
    reason_ = output.reason;
  }
  return output.command;
}

/// What the state asks for, before the drive's limits.
Twist2 Controller::wanted(const Target* target, const RobotMotion& when_it_acts, LawOutput* law_output) {
  std::optional<LawOutput> law;
  const bool uses_target = state_ == ControlState::acquire || state_ == ControlState::approach ||
                           state_ == ControlState::hold || state_ == ControlState::reacquire ||
                           state_ == ControlState::blocked;
  if (target != nullptr && uses_target) law = law_->command(target->p_CB, target->v_CB);
  if (law) *law_output = *law;

  switch (state_) {
    case ControlState::search:
      if (turned_rad_ == 0.0 && step_time_s_ - state_since_s_ < options_.look_s) return {};
      return {0.0, search_sign_ * options_.search_speed_radps};
    case ControlState::explore:
      return steered(excursion_to_, 0.0, std::nullopt, when_it_acts);
    case ControlState::blocked:
      if (before_blocked_ == ControlState::explore) {
        return steered(excursion_to_, 0.0, std::nullopt, when_it_acts);
      }
      [[fallthrough]];
    case ControlState::approach:
    case ControlState::reacquire:
      if (target == nullptr) return {};
      if (!steers()) return by_law(*target, law);
      return steered(in_world_frame(target->robot.pose, target->p_RB), options_.goal.distance_m,
                     by_law(*target, law), when_it_acts);
    default:
      return {};
  }
}

/// Keeps the drive's limits: a command to stop passes at once (the drive brakes as hard as it can), any other
/// changes no faster than the drive can follow. Guard and shield have the last word.
void Controller::finish(double time_s, const Twist2& wanted, const RobotMotion& when_it_acts,
                        ControlOutput& output) {
  Twist2 command;
  const bool stop = wanted.v_mps == 0.0 && wanted.w_radps == 0.0;
  if (!stop) {
    command = limit_acceleration(last_command_, wanted, options_.limits, 1.0 / options_.rate_hz);
    if (!std::isfinite(command.v_mps) || !std::isfinite(command.w_radps)) {
      command = {};
      enter(ControlState::fault, "a command was not finite", time_s);
    }
  }
  output.intended = command;
  if (avoidance_) {
    const ShieldVerdict verdict = avoidance_->check(time_s, command, when_it_acts);
    command = verdict.command;
    output.shield = verdict.reason;
  }
  predictor_.add_command(time_s, command);
  last_command_ = command;
  output.command = command;
}

}  // namespace ballservo
