// The controller's state machine.
#include <algorithm>
#include <cmath>

#include "servo/control/controller.hpp"
#include "servo/control/controller_target.hpp"

namespace ballservo {

namespace {

constexpr int sightings_to_trust = 3;  // confirmed ones, before the robot drives on them
constexpr double acquire_s = 0.5;      // a sighting that is not confirmed within it is let go
constexpr double coast_s = 0.6;        // the robot drives on the prediction so long without a sighting
constexpr double stale_s = 0.2;        // without a frame (beyond the latency) for so long, the robot stops
constexpr double search_aside_rad =
    0.6;  // the first search turns so far to one side, then the other way round
constexpr double search_turn_rad = 6.8;  // a turn and a little more
constexpr int excursions = 5;            // to other places to look from, with avoidance, before a search ends
constexpr double excursion_m = 1.8, excursion_s = 10.0;  // at most so far and so long each
constexpr double remember_s = 30.0;  // a ball out of sight is driven to for so long, with avoidance
// Both errors below the first: arrived. Either above the second: correct.
constexpr double hold_range_m = 0.0004, resume_range_m = 0.0025;
constexpr double hold_bearing_rad = 0.0004, resume_bearing_rad = 0.0025;

}  // namespace

std::string_view control_state_name(ControlState state) {
  switch (state) {
    case ControlState::search:
      return "search";
    case ControlState::explore:
      return "explore";
    case ControlState::acquire:
      return "acquire";
    case ControlState::approach:
      return "approach";
    case ControlState::hold:
      return "hold";
    case ControlState::reacquire:
      return "reacquire";
    case ControlState::blocked:
      return "blocked";
    case ControlState::lost:
      return "lost";
    case ControlState::given_up:
      return "given_up";
    case ControlState::stale:
      return "stale";
    case ControlState::fault:
      break;
  }
  return "fault";
}

void Controller::enter(ControlState state, std::string_view reason, double time_s) {
  if (state != state_) {
    state_since_s_ = turning_s_ = time_s;
    if (avoidance_ && state_ != ControlState::blocked && state != ControlState::blocked) {
      avoidance_->reset_steering();
    }
  }
  state_ = state;
  reason_ = reason;
}

/// The ball is out of sight: to where it was last, or, without a way to look for, to a stop.
void Controller::lose(std::string_view reason, double time_s) {
  ++lost_events_;
  confirmed_ = 0;
  sought_since_s_ = time_s;
  if (steers()) {
    enter(ControlState::reacquire, "out of sight: driving to where it was last", time_s);
  } else {
    enter(ControlState::lost, reason, time_s);
  }
}

/// A turn has shown nothing: to another place to look from, or the end.
void Controller::search_on(double time_s, const Pose2& odometry) {
  search_flips_ = 0;
  turning_s_ = time_s;
  if (!steers() || excursions_ >= excursions) {
    return enter(ControlState::given_up, "turned all around without seeing the ball", time_s);
  }
  // Towards where the robot looked at first, then further and further aside, to and fro.
  const double aside = (excursions_ % 2 == 0 ? 1.0 : -1.0) * 0.7 * ((excursions_ + 1) / 2);
  ++excursions_;
  excursion_to_ = avoidance_->open_place(time_s, start_yaw_rad_ + aside, excursion_m);
  turned_rad_ = 0;
  // No way straight ahead: back to where the run began.
  if ((excursion_to_ - Eigen::Vector2d(odometry.x_m, odometry.y_m)).norm() < 0.4) excursion_to_ = start_O_;
  excursion_since_s_ = time_s;
  enter(ControlState::explore, "not here: driving to another place to look from", time_s);
}

/// Arrived, braking included, or out of time.
bool Controller::excursion_ends(double time_s, const Pose2& odometry, const Twist2& twist) const {
  const double brake_m = 0.5 * twist.v_mps * twist.v_mps / options_.limits.a_max_mps2;
  return time_s - excursion_since_s_ > excursion_s ||
         (excursion_to_ - Eigen::Vector2d(odometry.x_m, odometry.y_m)).norm() < 0.15 + brake_m;
}

/// The state machine; every transition says why.
void Controller::update_state(double time_s, const Pose2& odometry, const Twist2& twist,
                              const Target* target) {
  const double turned_rad = std::abs(wrap_angle(odometry.yaw_rad - last_yaw_rad_));
  last_yaw_rad_ = odometry.yaw_rad;
  if (state_ == ControlState::search) turned_rad_ += turned_rad;

  if (bad_measurement_) return enter(ControlState::fault, "a measurement is not finite", time_s);
  if (time_s - frame_time_s_ > options_.latency_s + stale_s) {
    if (state_ != ControlState::given_up) enter(ControlState::stale, "no frames from the camera", time_s);
    return;
  }

  const double unseen_s = time_s - options_.latency_s - sighting_time_s_;
  const bool seen = target != nullptr && unseen_s <= coast_s;
  const bool just_seen = seen && unseen_s <= 0.5 * acquire_s;
  const bool trusted = seen && confirmed_ >= sightings_to_trust;
  const double in_state_s = time_s - state_since_s_;
  if (target != nullptr && seen) search_sign_ = target->bearing_rad < 0.0 ? -1.0 : 1.0;
  const bool driving_to_ball = state_ == ControlState::approach ||
                               (state_ == ControlState::blocked && before_blocked_ == ControlState::approach);

  switch (state_) {
    case ControlState::search:
    case ControlState::lost:
    case ControlState::given_up:
      if (just_seen) {
        enter(ControlState::acquire, "a ball is seen: stand until it is confirmed", time_s);
      } else if (state_ == ControlState::lost) {
        if (std::abs(twist.v_mps) + std::abs(twist.w_radps) < 0.01 && in_state_s > look_s) {
          turned_rad_ = 0;
          enter(ControlState::search, "not seen again: turning towards where it went", time_s);
        }
      } else if (state_ == ControlState::search) {
        // Where the shield lets the robot turn no further, the other way round; then it is as if turned.
        const bool looks = turned_rad_ == 0.0 && in_state_s < look_s;
        if (looks || std::abs(twist.w_radps) > 0.1) turning_s_ = time_s;
        if (time_s - turning_s_ > 0.8) {
          search_sign_ = -search_sign_;
          ++search_flips_;
          turning_s_ = time_s;
        }
        // Where a robot is set down, the ball is rather ahead than behind.
        if (!looked_aside_ && turned_rad_ >= search_aside_rad) {
          looked_aside_ = true;
          turned_rad_ = 0;
          search_sign_ = -search_sign_;
        }
        if (turned_rad_ >= search_turn_rad || search_flips_ >= 2) search_on(time_s, odometry);
      }
      break;

    case ControlState::explore:
      if (just_seen) {
        enter(ControlState::acquire, "a ball is seen: stand until it is confirmed", time_s);
      } else if (excursion_ends(time_s, odometry, twist)) {
        turned_rad_ = 0;
        // Towards where the robot looked at first: the ball is there, behind something.
        search_sign_ = wrap_angle(start_yaw_rad_ - odometry.yaw_rad) < 0.0 ? -1.0 : 1.0;
        enter(ControlState::search, "at another place: turning to look from here", time_s);
      }
      break;

    case ControlState::acquire:
    case ControlState::stale:
    case ControlState::fault:
      if (trusted) {
        had_ball_ = true;
        excursions_ = 0;
        enter(ControlState::approach, "the ball is confirmed: driving to it", time_s);
      } else if (state_ != ControlState::acquire) {
        if (seen) {
          enter(ControlState::acquire, "frames are good again: stand until the ball is confirmed", time_s);
        } else if (had_ball_) {
          lose("frames are good again, but the ball is not in them: stopped", time_s);
        } else {
          enter(ControlState::search, "frames are good again: looking for the ball", time_s);
        }
      } else if (unseen_s > acquire_s || in_state_s > 4.0 * acquire_s) {
        if (had_ball_ && steers()) {
          lose("what was seen was not confirmed", time_s);
        } else {
          enter(ControlState::search, "what was seen was not confirmed", time_s);
        }
      }
      break;

    case ControlState::reacquire:
    case ControlState::blocked:
    case ControlState::approach:
    case ControlState::hold:
      if (state_ == ControlState::hold || driving_to_ball) {
        follow(time_s, seen, trusted, target);
      } else {
        remember(time_s, just_seen, target);
      }
      break;
  }
}

/// With the ball in sight: approach, hold, and blocked on the way.
void Controller::follow(double time_s, bool seen, bool trusted, const Target* target) {
  if (!seen) return lose("the ball has not been seen for too long: stopped", time_s);
  if (!trusted) {
    return enter(ControlState::acquire, "the track began anew: stand until it is confirmed", time_s);
  }
  if (state_ == ControlState::blocked) return;
  const double range_m = std::abs(target->range_error_m), bearing_rad = std::abs(target->bearing_rad);
  const bool rests = target->v_RB.isZero(0.0);
  const bool slow =
      std::abs(target->robot.twist.v_mps) < 0.005 && std::abs(target->robot.twist.w_radps) < 0.01;
  if (state_ == ControlState::approach) {
    if (rests && slow && range_m <= hold_range_m && bearing_rad <= hold_bearing_rad) {
      enter(ControlState::hold, "arrived: standing at the goal", time_s);
    }
  } else if (!rests || range_m > resume_range_m || bearing_rad > resume_bearing_rad) {
    enter(ControlState::approach, "off the goal: correcting", time_s);
  }
}

/// With the ball out of sight: reacquire, and blocked on the way there or to another place.
void Controller::remember(double time_s, bool just_seen, const Target* target) {
  if (just_seen) return enter(ControlState::acquire, "the ball is back: stand until it is confirmed", time_s);
  if (state_ == ControlState::blocked && before_blocked_ == ControlState::explore) {
    if (time_s - excursion_since_s_ > excursion_s) {
      turned_rad_ = 0;
      enter(ControlState::search, "no way on: turning to look from here", time_s);
    }
    return;
  }
  if (target == nullptr) return enter(ControlState::lost, "nothing is remembered of the ball", time_s);
  // Where it should be in the picture and is not, it is gone.
  const bool should_see = std::abs(target->range_error_m) < 0.25 && std::abs(target->bearing_rad) < 0.3;
  if (!should_see) sought_since_s_ = time_s;
  if (time_s - sought_since_s_ > look_s || time_s - sighting_time_s_ > remember_s) {
    enter(ControlState::lost, "not where it was last: stopped", time_s);
  }
}

}  // namespace ballservo
