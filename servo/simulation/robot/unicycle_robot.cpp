#include "servo/simulation/robot/unicycle_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"
#include "calibration/base/options.hpp"

namespace ballservo {

namespace {
constexpr double longest_step_s = 1e-3;
constexpr double own_share = 0.7;  // of odometry's bound: errors that last
}  // namespace

UnicycleRobot::UnicycleRobot(const Pose2& start, const UnicycleLimits& limits, double actuation_delay_s)
    : motion_{start, {}}, limits_(limits), delay_s_(actuation_delay_s) {
  // Any drive can be simulated, a share of the limits or a drive without any among them.
  for (const double limit :
       {limits_.v_max_mps, limits_.w_max_radps, limits_.a_max_mps2, limits_.alpha_max_radps2}) {
    if (!(std::isfinite(limit) && limit > 0))
      throw InputError("limits", fmt::format("{}", limit), "numbers above 0");
  }
  if (!(std::isfinite(delay_s_) && delay_s_ >= 0)) {
    throw InputError("actuation_delay_s",
                     std::isfinite(delay_s_) ? number_text(delay_s_) : "not a finite number",
                     "a number from 0 (s)");
  }
}

void UnicycleRobot::command(const Twist2& twist) {
  pending_.push_back({time_s_ + delay_s_, twist.is_finite() ? twist : Twist2{}});
}

RobotMotion UnicycleRobot::advance_to(double time_s) {
  while (!pending_.empty() && pending_.front().time_s <= time_s) {
    drive(pending_.front().time_s);
    followed_ = pending_.front().twist;
    pending_.pop_front();
  }
  drive(time_s);
  return motion_;
}

void UnicycleRobot::drive(double until_s) {
  const double span_s = until_s - time_s_;
  if (!(span_s > 0)) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(span_s / longest_step_s - 1e-9)));
  motion_ = ballservo::drive(motion_, followed_, limits_, span_s, steps);
  time_s_ = until_s;
}

void declare(OptionVisitor& v, OdometryOptions& odometry) {
  declare(v, odometry.bound);
  v.number("excess", odometry.excess, NumberRange::within(0, 100, ""),
           "errors, as a multiple of those bounds; above 1 an assumption is broken");
}

Odometry::Odometry(const OdometryOptions& options, const Pose2& start, std::uint64_t seed)
    : options_(options), engine_(random_stream(seed, "odometry")), pose_(start), true_pose_(start) {
  const OdometryBound& bound = options.bound;
  exact_ = options.excess == 0 ||
           (bound.distance_share == 0 && bound.turn_share == 0 && bound.turn_per_m_radpm == 0);
  scale_error_ = own_share * uniform(engine_, -1, 1);
  turn_error_ = own_share * uniform(engine_, -1, 1);
  veer_error_ = own_share * uniform(engine_, -1, 1);
}

void Odometry::move(const Pose2& true_pose) {
  if (exact_) {
    pose_ = true_pose;
    return;
  }
  const double turn_rad = true_pose.yaw_rad - true_pose_.yaw_rad;
  const double dx = true_pose.x_m - true_pose_.x_m, dy = true_pose.y_m - true_pose_.y_m;
  const double middle_rad = true_pose_.yaw_rad + 0.5 * turn_rad;
  const double half = 0.5 * turn_rad;
  const double chord_to_arc = std::abs(half) < 1e-6 ? 1.0 : half / std::sin(half);
  const double path_m = chord_to_arc * (std::cos(middle_rad) * dx + std::sin(middle_rad) * dy);
  true_pose_ = true_pose;

  const OdometryBound& bound = options_.bound;
  const auto error = [this](double own) {
    return options_.excess * (own + (1.0 - own_share) * uniform(engine_, -1, 1));
  };
  const double scale = bound.distance_share * error(scale_error_),
               turn = bound.turn_share * error(turn_error_),
               veer = bound.turn_per_m_radpm * error(veer_error_);
  pose_ = integrate(pose_, {path_m * (1.0 + scale), turn_rad * (1.0 + turn) + veer * path_m}, 1.0);
}

Twist2 Odometry::measure(const Twist2& twist) const {
  return {twist.v_mps * (1.0 + options_.bound.distance_share * options_.excess * scale_error_),
          twist.w_radps * (1.0 + options_.bound.turn_share * options_.excess * turn_error_)};
}

}  // namespace ballservo
