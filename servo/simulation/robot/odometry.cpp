#include "servo/simulation/robot/odometry.hpp"

#include <cmath>

#include "calibration/base/options.hpp"

namespace ballservo {

namespace {
constexpr double own_share = 0.7;  // of the bound: errors that last
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
