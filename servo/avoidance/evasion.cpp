#include "servo/avoidance/evasion.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ballservo {

namespace {

constexpr double horizon_s = 10.0, forecast_step_s = 0.2;
constexpr double roomy_m = 0.4, better_m = 0.02;
constexpr double touch_m = 0.02;
constexpr double passes_within_m = 1.5;  // what comes no nearer within the horizon is not reckoned with
// A guess counts until its velocity's doubt has moved it by so much of its radius.
constexpr double doubtful_radii = 2.0;

/// A touch is worse than any room, the sooner the worse: what is far ahead can still be avoided.
double worth_of_touch_m(double after_s) {
  constexpr double soon_s = 3.0, soon_m = -0.5, late_m = 0.22;
  return soon_m + (late_m - soon_m) * std::clamp((after_s - soon_s) / (horizon_s - soon_s), 0.0, 1.0);
}

}  // namespace

/// What the least room on the way is worth, the command held for so long and rest after it, if that guess is
/// right of every mover; no more than enough.
double Evasion::worth_m(const Twist2& command, double held_s, RobotMotion robot,
                        const MoverTracker::Movers& movers, std::size_t guess) const {
  const auto room_after_m = [&](double after_s) {
    double room_m = 1e3;
    const Eigen::Vector2d p_OR(robot.pose.x_m, robot.pose.y_m);
    const Eigen::Matrix2d R_RO = Eigen::Rotation2Dd(-robot.pose.yaw_rad).toRotationMatrix();
    for (std::size_t k = 0; k < movers.count; ++k) {
      const Mover& mover = movers.movers[k];
      if (after_s * mover.speed_sigma_mps > doubtful_radii * moving_.radius_m) continue;
      const Eigen::Vector2d p_R = R_RO * (mover.discs[guess].p_O + after_s * mover.discs[guess].v_O - p_OR);
      room_m = std::min(room_m, shield_.footprint.distance_m(p_R) - moving_.radius_m);
    }
    return room_m;
  };
  // The shield lets the robot go no faster than it can come to rest before what it last heard a second ago.
  const double still_m = 0.05 + moving_.speed_mps * 1.0;
  const double mps_per_m = shield_.limits.a_max_mps2 / moving_.speed_mps;
  double room_m = room_after_m(0), least_m = roomy_m;
  for (int k = 0; k * forecast_step_s < horizon_s; ++k) {
    const double allowed_mps = std::max(0.0, mps_per_m * (room_m - still_m));
    Twist2 driven = k * forecast_step_s < held_s - 1e-9 && allowed_mps > 0.0 ? command : Twist2{};
    if (std::abs(driven.v_mps) > allowed_mps) {
      const double share = allowed_mps / std::abs(driven.v_mps);
      driven = {share * driven.v_mps, share * driven.w_radps};
    }
    if (!driven.rests() || !robot.twist.rests())
      robot = drive(robot, driven, shield_.limits, forecast_step_s, 1);
    room_m = room_after_m((k + 1) * forecast_step_s);
    if (room_m < touch_m) return worth_of_touch_m(k * forecast_step_s);
    least_m = std::min(least_m, room_m);
  }
  return least_m;
}

/// The mean over the guesses; where it is no more than `least_m`, that or less.
double Evasion::mean_worth_m(const Twist2& command, double held_s, const RobotMotion& when_it_acts,
                             const MoverTracker::Movers& movers, double least_m) const {
  double most_m = roomy_m;
  for (std::size_t guess = 0; guess < Mover::guesses && most_m > least_m; ++guess)
    most_m -= (roomy_m - worth_m(command, held_s, when_it_acts, movers, guess)) / Mover::guesses;
  return most_m;
}

std::optional<Twist2> Evasion::command(const Twist2& wanted, const RobotMotion& when_it_acts,
                                       const MoverTracker::Movers& all, const OccupancyGrid& grid,
                                       const MovingThings& things) const {
  const Eigen::Vector2d p_OR(when_it_acts.pose.x_m, when_it_acts.pose.y_m);
  const auto comes_near = [&p_OR](const Mover& mover) {
    return std::any_of(mover.discs.begin(), mover.discs.end(), [&p_OR](const MovingDisc& disc) {
      const Eigen::Vector2d to_robot = p_OR - disc.p_O;
      const double nearest_s = to_robot.dot(disc.v_O) / std::max(1e-9, disc.v_O.squaredNorm());
      return (to_robot - std::clamp(nearest_s, 0.0, horizon_s) * disc.v_O).norm() < passes_within_m;
    });
  };
  MoverTracker::Movers movers;
  for (std::size_t k = 0; k < all.count; ++k) {
    if (comes_near(all.movers[k])) movers.movers[movers.count++] = all.movers[k];
  }
  if (movers.count == 0) return std::nullopt;
  double best_m = -1;
  for (const double held_s : {0.1, 0.5, 1.0, 2.0, 3.0, 5.0}) {
    best_m = std::max(best_m, mean_worth_m(wanted, held_s, when_it_acts, movers, best_m));
    if (best_m >= roomy_m) return std::nullopt;
  }
  std::optional<Twist2> best;
  for (const double v_mps : {0.0, -0.3, 0.3, -0.6, 0.6}) {
    for (const double w_radps : {0.0, 0.5, -0.5}) {
      const Twist2 command{v_mps, w_radps};
      const Twist2 next = limit_acceleration(when_it_acts.twist, command, shield_.limits, 0.1);
      if (can_brake_after(next, when_it_acts, grid, shield_, &things) == Brake::blocked) continue;
      for (const double held_s : {0.5, 1.0, 2.0, 3.0}) {
        const double worth_m = mean_worth_m(command, held_s, when_it_acts, movers, best_m + better_m);
        if (worth_m <= best_m + better_m) continue;
        best_m = worth_m;
        best = command;
      }
    }
  }
  return best;
}

}  // namespace ballservo
