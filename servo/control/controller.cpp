#include "servo/control/controller.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "calibration/base/options.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace {

constexpr int sightings_to_trust = 3;    // confirmed ones, before the robot drives on them
constexpr double acquire_s = 0.5;        // a sighting that is not confirmed within it is let go
constexpr double coast_s = 0.6;          // the robot drives on the prediction so long without a sighting
constexpr double stale_s = 0.2;          // without a frame (beyond the latency) for so long, the robot stops
constexpr double little_m2 = 0.3;        // a turn that shows less floor is not worth it
constexpr double remember_s = 30.0;      // a ball out of sight is driven to for so long, with avoidance
constexpr double turn_first_rad = 1.05;  // a ball further to the side is turned to before the law drives
// Both errors below the first: arrived. Either above the second: correct.
constexpr double hold_range_m = 0.0004, resume_range_m = 0.0025;
constexpr double hold_bearing_rad = 0.0004, resume_bearing_rad = 0.0025;
// Such errors put a ball well inside the picture.
constexpr double in_view_range_m = 0.25, in_view_bearing_rad = 0.3;
// A goal that was shown holds for any diameter: this is not known then of what places are multiplied with.
constexpr double taught_scale_sigma = 0.7;
// A camera with a pan lets the ball go so far aside, of half the picture, to look ahead.
constexpr double ball_aside = 0.5;

bool finite(const Pose2& pose) {
  // Beyond these a pose is as good as not finite: differences would lose the millimetres.
  return std::abs(pose.x_m) < 1e6 && std::abs(pose.y_m) < 1e6 && std::abs(pose.yaw_rad) < 1e6;
}
bool finite(const PanMotion& pan) { return std::isfinite(pan.angle_rad) && std::isfinite(pan.speed_radps); }
bool finite(const Twist2& twist) { return std::abs(twist.v_mps) < 1e3 && std::abs(twist.w_radps) < 1e3; }

/// Whether the law's errors are told in that state.
bool asks_law(ControlState state) {
  return state == ControlState::acquire || state == ControlState::approach || state == ControlState::hold ||
         state == ControlState::reacquire || state == ControlState::blocked;
}

std::size_t history_length(double rate_hz) { return static_cast<std::size_t>(std::ceil(5.0 * rate_hz)) + 8; }

const ControllerOptions& checked(const ControllerOptions& options) {
  check_options("controller", options);
  return options;
}

}  // namespace

void declare(OptionVisitor& v, ControllerOptions& options) {
  v.number("rate_hz", options.rate_hz, NumberRange::above(0, 10000, "Hz"), "control steps");
  v.number("latency_s", options.latency_s, NumberRange::within(0, 2, "s"),
           "from the middle of an exposure to its measurement");
  v.number("actuation_delay_s", options.actuation_delay_s, NumberRange::within(0, 2, "s"),
           "from a command until it moves the robot");
  v.number("command_s", options.command_s, NumberRange::at_least(0, "s"),
           "a command drives at most so long; 0: a period");
  v.number("turn_gain_per_s", options.turn_gain_per_s, NumberRange::above(0, "1/s"),
           "of the turn towards a ball for which the law has no answer");
  v.part("limits", options.limits);
  v.part("goal", options.goal);
  AvoidanceOptions& avoidance = options.avoidance;
  v.only_if(avoidance.type != AvoidanceOptions::Type::none, "avoidance.type: shield, full", [&] {
    v.part("avoidance", avoidance);
    v.part("sonar", avoidance.grid.beam);
    v.part("odometry", avoidance.grid.odometry);
    v.number("range_error_m", avoidance.grid.range_error_m, NumberRange::at_least(0, "m"),
             "of a sonar, at most");
    v.number("half_view_rad", avoidance.half_view_rad, NumberRange::above(0, "rad"),
             "the ball further aside is unseen");
  });
}

Controller::Controller(const ControllerOptions& options, std::unique_ptr<Law> law)
    : options_(checked(options)),
      law_(std::move(law)),
      poses_(history_length(options.rate_hz)),
      predictor_(options.limits, options.actuation_delay_s, history_length(options.rate_hz)),
      gaze_(options.goal.mount, ball_aside * options.avoidance.half_view_rad, options.actuation_delay_s,
            history_length(options.rate_hz)),
      ball_(options.goal.mount, options.goal.taught_center_over_radius ? taught_scale_sigma : 0.0),
      states_(options.avoidance.type == AvoidanceOptions::Type::full) {
  if (!law_) throw std::invalid_argument("a Controller needs a law");
  if (options.avoidance.type != AvoidanceOptions::Type::none) {
    const double command_s = options.command_s > 0.0 ? options.command_s : 1.0 / options.rate_hz;
    avoidance_.emplace(options.avoidance, options.limits, options.actuation_delay_s, command_s);
  }
}

void Controller::retune(const ControllerOptions& options, std::unique_ptr<Law> law) {
  law_ = std::move(law);
  options_.turn_gain_per_s = options.turn_gain_per_s;
  options_.latency_s = options.latency_s;
  options_.avoidance.type = options.avoidance.type;
  if (steers() || !states_.blocked()) return;
  react(Finding::unstuck, step_time_s_, {});  // nobody looks for a way any longer
}

void Controller::note_command(double time_s, const Twist2& command) {
  drive_ = driven(time_s);
  commanded_s_ = time_s;
  last_command_ = command;
  predictor_.add_command(time_s, command);
}

SensorStamps Controller::stamps() const {
  SensorStamps stamps = avoidance_ ? avoidance_->watch().stamps() : SensorStamps{};
  stamps.frame_s = ball_.frame_arrived_s();
  stamps.step_s = step_time_s_;
  return stamps;
}

// The whole loop: look, predict, decide, ask the law, steer, keep within what the robot can do.
ControlOutput Controller::step(double time_s, const Pose2& odometry, const Twist2& odometry_twist) {
  ControlOutput output;
  if (std::isfinite(time_s) && time_s > step_time_s_ && finite(odometry) && finite(odometry_twist) &&
      finite(pan_)) {
    if (!std::isfinite(step_time_s_)) {
      states_.start(time_s);
      ball_.start(time_s);
      search_.start(time_s, odometry);
    }
    step_time_s_ = time_s;
    poses_.add(time_s, odometry);
    ball_.take_in(time_s, poses_);
    if (avoidance_) {
      avoidance_->see_frame(ball_.frame_arrived_s(), pan_.angle_rad);
      avoidance_->update(time_s, odometry, poses_);
    }
    const RobotMotion now{odometry,
                          predictor_.twist_at(time_s, odometry_twist, options_.avoidance.grid.odometry)};
    const RobotMotion when_it_acts = predictor_.predict(time_s, now);
    const std::optional<Target> target = predict_target(time_s, when_it_acts);

    react(look_around(time_s, now, when_it_acts, target), time_s, odometry);

    std::optional<LawOutput> law;
    if (target && asks_law(states_.state())) law = ask_law(*target);
    if (law) {
      output.error_1 = law->error_1;
      output.error_2 = law->error_2;
    }
    const Wish wish = wanted(time_s, odometry, when_it_acts, target, law);
    output.intended = within_limits(time_s, wish.way ? steered(*wish.way) : wish.command, odometry);
    output.command = output.intended;
    if (is_cautious()) {
      const ShieldVerdict verdict = avoidance_->check(time_s, output.intended, when_it_acts);
      output.command = verdict.command;
      output.shield = verdict.reason;
    }
    note_command(time_s, output.command);
    output.pan_radps = pan_speed(time_s, target, when_it_acts.twist);
  } else {
    react(Finding::bad_clock, step_time_s_, odometry);
    ball_.clear_inbox();
    if (std::isfinite(step_time_s_)) note_command(step_time_s_, {});
  }
  output.state = states_.state();
  output.reason = states_.reason();
  output.track_state = ball_.track_state();
  output.lost_events = states_.lost_events();
  return output;
}

/// The ball relative to the robot at the moment when a command given now acts; nothing if it is not known.
std::optional<Controller::Target> Controller::predict_target(double time_s,
                                                             const RobotMotion& when_it_acts) const {
  const auto estimate = ball_.predict(time_s + options_.actuation_delay_s);
  if (!estimate) return std::nullopt;
  const Eigen::Isometry3d X_RO = X_WR(when_it_acts.pose).inverse();
  const Eigen::Isometry3d X_CR = options_.goal.mount.X_RC().inverse();
  const Eigen::Vector3d p_RB = X_RO * estimate->p_OB;
  const Eigen::Vector3d v_RB = X_RO.linear() * Eigen::Vector3d(estimate->v_OB.x(), estimate->v_OB.y(), 0.0);
  Target target;
  target.p_RB = p_RB.head<2>();
  target.v_RB = v_RB.head<2>();
  target.p_CB = X_CR * p_RB;
  target.v_CB = X_CR.linear() * v_RB;
  target.scale = estimate->scale;
  const Eigen::Vector3d goal = options_.goal.desired_p_RB(estimate->scale);
  target.range_error_m = target.p_RB.norm() - goal.head<2>().norm();
  target.bearing_rad =
      wrap_angle(std::atan2(target.p_RB.y(), target.p_RB.x()) - std::atan2(goal.y(), goal.x()));
  if (!std::isfinite(target.range_error_m) || !std::isfinite(target.bearing_rad)) return std::nullopt;
  return target;
}

/// The law and its goal know places as sightings have them.
std::optional<LawOutput> Controller::ask_law(const Target& target) const {
  std::optional<LawOutput> output = law_->command(target.scale * target.p_CB, target.scale * target.v_CB);
  if (output) output->twist.v_mps /= target.scale;
  return output;
}

/// What the table of states is asked about; the search and the place where the ball is expected go on by it.
Findings Controller::look_around(double time_s, const RobotMotion& now, const RobotMotion& when_it_acts,
                                 const std::optional<Target>& target) {
  Findings findings;
  const ControlState activity = states_.activity();
  search_.note_heading(now.pose.yaw_rad, activity == ControlState::search);

  findings.add(Finding::bad_measurement, ball_.nonsense());
  const bool frames = !(time_s - ball_.frame_s() > options_.latency_s + stale_s);
  findings.add(frames ? Finding::frames : Finding::no_frames);
  if (!frames || ball_.nonsense()) return findings;

  const double unseen_s = time_s - options_.latency_s - ball_.sighting_s();
  const bool seen = target && unseen_s <= coast_s,
             seen_now = seen && unseen_s <= 0.5 * acquire_s &&
                        !(activity == ControlState::search && search_.passes_over(time_s));
  const bool trusted = seen && ball_.confirmed() >= sightings_to_trust;
  findings.add(seen ? Finding::seen : Finding::unseen);
  findings.add(trusted ? Finding::trusted : Finding::untrusted);
  findings.add(Finding::seen_now, seen_now);
  if (seen) search_.note_ball(target->bearing_rad);

  const double in_state_s = time_s - states_.since_s();
  const double range_m = target ? std::abs(target->range_error_m) : 0.0;
  const double bearing_rad = target ? std::abs(target->bearing_rad) : 0.0;
  const double aside_rad = target ? std::abs(target->bearing_rad - pan_.angle_rad) : 0.0;
  switch (activity) {
    case ControlState::search: {
      bool saw_all = false;
      if (steers()) {
        const UnseenFloor unseen = avoidance_->unseen_from_here();
        if (search_.has_set_out()) search_.prefer(unseen.sooner_left);
        saw_all = in_state_s > Search::look_s && unseen.area_m2 < little_m2;
      }
      findings.add(Finding::turned_around, !seen_now && (search_.turn(time_s, now.twist) || saw_all));
      findings.add(Finding::no_place_left, !steers() || !search_.may_set_out());
      break;
    }
    case ControlState::explore:
      findings.add(Finding::arrived_there, search_.arrives(now.pose, now.twist, options_.limits.a_max_mps2));
      findings.add(Finding::out_of_time, search_.out_of_time(time_s));
      break;
    case ControlState::acquire:
      findings.add(Finding::unconfirmed, unseen_s > acquire_s || in_state_s > 4.0 * acquire_s);
      break;
    case ControlState::approach:
    case ControlState::hold: {
      const Twist2& twist = when_it_acts.twist;
      const bool ball_rests = target && target->v_RB.isZero(0.0);
      const bool slow = std::abs(twist.v_mps) < 0.005 && std::abs(twist.w_radps) < 0.01;
      findings.add(Finding::arrived,
                   ball_rests && slow && range_m <= hold_range_m && bearing_rad <= hold_bearing_rad);
      findings.add(Finding::off_goal,
                   !ball_rests || range_m > resume_range_m || bearing_rad > resume_bearing_rad);
      break;
    }
    case ControlState::reacquire:
      findings.add(Finding::nothing_known, !target);
      findings.add(Finding::not_there, search_.misses_ball(time_s, range_m < in_view_range_m &&
                                                                       aside_rad < in_view_bearing_rad) ||
                                           time_s - ball_.sighting_s() > remember_s);
      break;
    case ControlState::lost:
      findings.add(Finding::stands, std::abs(now.twist.v_mps) + std::abs(now.twist.w_radps) < 0.01 &&
                                        in_state_s > Search::look_s);
      break;
    default:
      break;
  }
  return findings;
}

/// The transition that the findings allow, and what it brings about.
void Controller::react(const Findings& findings, double time_s, const Pose2& pose) {
  const bool was_blocked = states_.blocked();
  const Transition* transition = states_.react(findings, time_s);
  if (transition == nullptr) return;
  if (avoidance_ && !was_blocked && !states_.blocked()) avoidance_->reset_steering();
  switch (transition->effect) {
    case Effect::begin_turn:
      return search_.begin_turn(time_s);
    case Effect::resume_turn:
      return search_.resume_turn(time_s);
    case Effect::pass_over:
      return search_.pass_over(time_s);
    case Effect::set_out:
      return search_.set_out(time_s, pose, avoidance_->place_to_look_from());
    case Effect::trust:
      return search_.forget_excursions();
    case Effect::lose:
      ball_.doubt();
      if (const auto ball = ball_.predict(time_s); avoidance_ && ball)
        avoidance_->expect_ball(ball->p_OB.head<2>());
      return search_.expect_ball(time_s);
    case Effect::none:
      return;
  }
}

/// The camera looks at where the ball is held to be. While the robot turns to look for it, the camera goes
/// ahead of the turn; on the way to another place it looks around.
double Controller::pan_speed(double time_s, const std::optional<Target>& target, const Twist2& twist) {
  const ControlState activity = states_.activity();
  if (activity == ControlState::explore) return gaze_.scan(time_s, pan_);
  if (activity == ControlState::search) {
    const double turn_radps = search_.turn_command(time_s).w_radps;
    return gaze_.look_aside(turn_radps == 0.0 ? 0.0 : std::copysign(1.0, turn_radps), time_s, pan_);
  }
  if (!target) return gaze_.look_aside(0, time_s, pan_);
  return gaze_.follow(time_s, pan_, {target->p_RB, target->v_RB}, twist);
}

/// What the state asks for, before the drive's limits.
Controller::Wish Controller::wanted(double time_s, const Pose2& pose, const RobotMotion& when_it_acts,
                                    const std::optional<Target>& target,
                                    const std::optional<LawOutput>& law) const {
  switch (states_.activity()) {
    case ControlState::search:
      return {search_.turn_command(time_s), {}};
    case ControlState::explore:
      return {{}, SteeringInput{time_s, pose, when_it_acts, search_.destination(), 0.0, std::nullopt}};
    case ControlState::approach:
    case ControlState::reacquire: {
      if (!target) return {};
      const Twist2 command = by_law(*target, when_it_acts.twist, law);
      if (!steers()) return {command, {}};
      const Eigen::Vector2d p_OB = in_world_frame(when_it_acts.pose, target->p_RB);
      return {{}, SteeringInput{time_s, pose, when_it_acts, p_OB, options_.goal.distance_m, command}};
    }
    default:
      return {};
  }
}

/// The law's command within the envelope that braking allows; `twist`: of the robot when the command acts.
Twist2 Controller::by_law(const Target& target, const Twist2& twist,
                          const std::optional<LawOutput>& law) const {
  // The distance that the robot still covers before this command's own period is over.
  const double e = target.range_error_m;
  const double covered_m = twist.v_mps / options_.rate_hz;
  const double left_m =
      e > 0.0 ? std::max(0.0, e - std::max(0.0, covered_m)) : std::min(0.0, e - std::min(0.0, covered_m));
  Twist2 command;
  if (law && std::abs(target.bearing_rad) <= turn_first_rad) {
    command = law->twist;
  } else {
    command.w_radps = options_.turn_gain_per_s * target.bearing_rad;
  }
  return limit_to_envelope(command, left_m, target.p_RB, target.v_RB, options_.limits);
}

/// The way to a place among obstacles; the state tells where there is none.
Twist2 Controller::steered(const SteeringInput& way) {
  const SteeringOutput output = avoidance_->steer(way);
  if (output.no_way) search_.end_excursion();
  const bool was_blocked = states_.blocked();
  react(output.stuck ? Finding::stuck : Finding::unstuck, way.time_s, way.pose);
  // "going on" is said once; else steering says why.
  if (!was_blocked || states_.blocked()) states_.explain(output.reason);
  return output.command;
}

/// How a drive that keeps its limits turns the wheels then, by the commands so far.
Twist2 Controller::driven(double time_s) const {
  const double since_s = std::min(time_s - commanded_s_, 1e3);  // clocks may leap
  return since_s > 1e-9 ? limit_acceleration(drive_, last_command_, options_.limits, since_s) : drive_;
}

/// A command to stop passes at once: the drive brakes. Any other is one that the drive can follow within a
/// step from its motion, not from the last command: one that was stopped or slowed costs that step, no more.
Twist2 Controller::within_limits(double time_s, const Twist2& wanted, const Pose2& pose) {
  if (wanted.rests()) return {};
  const Twist2 command = limit_acceleration(driven(time_s), wanted, options_.limits, 1.0 / options_.rate_hz);
  if (command.is_finite()) return command;
  react(Finding::bad_command, time_s, pose);
  return {};
}

}  // namespace ballservo
