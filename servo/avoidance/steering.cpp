#include "servo/avoidance/steering.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace {
constexpr int field_every = 5;                       // control steps between two fields
constexpr double speed_mps = 0.6, turn_radps = 1.0;  // at most, among obstacles
constexpr double turn_gain_per_s = 2.2;
constexpr double sharp_rad = 0.7;      // a heading further aside is turned to on the spot
constexpr double braking_share = 0.6;  // of the drive's deceleration that the barrier counts on
constexpr double stuck_s = 0.8;        // so long without motion that was wanted: stuck
constexpr double ball_gap_m = 0.25;    // echoes so near the ball are the ball's
constexpr double barrier_m = 1.0;      // what is further from the axle does not bound the command
constexpr double small_turn_rad = 0.30, far_turn_rad = 1.4, back_up_m = 0.25;
constexpr double recovery_turn_radps = 0.6, recovery_back_mps = 0.15, recovery_s = 2.5;
constexpr double standing_s = 0.5;  // a recovery that moves nothing for so long gives way to the next

// Places to look from: every so many blocks, no nearer and no longer a way than this. A look costs the time
// of so much of way. Where all was seen, a place is worth a little: from there the map may show more.
constexpr int place_every = 3;
constexpr double nearest_place_m = 0.4, farthest_place_m = 12.0, look_m = 3.0, known_m2 = 0.05;

constexpr double tolerance = 1e-9;

/// The minimiser of 1/2 u^T H u - g^T u under the first `count` bounds.
std::optional<Eigen::Vector2d> minimise(const Eigen::Matrix2d& H, const Eigen::Vector2d& g,
                                        const LinearBound* bounds, std::size_t count) {
  const Eigen::Matrix2d H_inverse = H.inverse();
  const auto keeps_all = [&](const Eigen::Vector2d& u) {
    return std::all_of(bounds, bounds + count,
                       [&](const LinearBound& bound) { return bound.a.dot(u) <= bound.b + tolerance; });
  };
  double best_cost = std::numeric_limits<double>::infinity();
  Eigen::Vector2d best{0, 0};
  const auto consider = [&](const Eigen::Vector2d& u) {
    const double cost = 0.5 * u.dot(H * u) - g.dot(u);
    if (!(cost < best_cost) || !keeps_all(u)) return;
    best_cost = cost;
    best = u;
  };
  const Eigen::Vector2d free = H_inverse * g;
  if (keeps_all(free)) return free;
  for (std::size_t i = 0; i < count; ++i) {
    const LinearBound& p = bounds[i];
    const Eigen::Vector2d q = H_inverse * p.a;
    const double length2 = p.a.dot(q);
    if (length2 > 1e-15) consider(free + q * ((p.b - p.a.dot(free)) / length2));
    for (std::size_t j = 0; j < i; ++j) {
      const LinearBound& r = bounds[j];
      const double det = p.a.x() * r.a.y() - p.a.y() * r.a.x();
      if (std::abs(det) < 1e-12) continue;
      consider({(p.b * r.a.y() - p.a.y() * r.b) / det, (p.a.x() * r.b - p.b * r.a.x()) / det});
    }
  }
  return std::isfinite(best_cost) ? std::make_optional(best) : std::nullopt;
}

bool moves(const Twist2& twist) { return std::abs(twist.v_mps) > 0.02 || std::abs(twist.w_radps) > 0.05; }
}  // namespace

std::optional<Eigen::Vector2d> solve(const BarrierProblem& problem) {
  if (!problem.wanted.allFinite() || !(problem.weight.minCoeff() > 0.0)) return std::nullopt;
  std::array<LinearBound, BarrierProblem::max_bounds + 1> bounds;
  for (std::size_t k = 0; k < problem.count; ++k) {
    bounds[k] = problem.bounds[k];
    if (!bounds[k].a.allFinite() || !std::isfinite(bounds[k].b)) return std::nullopt;
  }
  Eigen::Matrix2d H = problem.weight.asDiagonal();
  Eigen::Vector2d g = problem.weight.cwiseProduct(problem.wanted);
  if (!problem.soft) return minimise(H, g, bounds.data(), problem.count);

  const LinearBound& soft = *problem.soft;
  if (!soft.a.allFinite() || !std::isfinite(soft.b)) return std::nullopt;
  // The cost is convex: where the minimum over the side that keeps the soft bound does not touch it, it is
  // the minimum of all; else the other side holds one that is as good.
  bounds[problem.count] = soft;
  const auto kept = minimise(H, g, bounds.data(), problem.count + 1);
  if (kept && soft.a.dot(*kept) < soft.b - tolerance) return kept;
  H += problem.slack_weight * soft.a * soft.a.transpose();
  g += problem.slack_weight * soft.b * soft.a;
  bounds[problem.count] = {-soft.a, -soft.b};
  const auto left = minimise(H, g, bounds.data(), problem.count + 1);
  return left ? left : kept;
}

Steering::Steering(double half_view_rad, const UnicycleLimits& limits, const Footprint& footprint)
    : half_view_rad_(half_view_rad), limits_(limits), footprint_(footprint) {}

Eigen::Vector2d Steering::place_to_look_from(double time_s, const OccupancyGrid& grid,
                                             const ViewedFloor& viewed) {
  const Eigen::Vector2d p_OR(grid.pose().x_m, grid.pose().y_m);
  navigation_.update_from_robot(grid, time_s);
  Eigen::Vector2d best_place = p_OR;
  double best = 0.0;
  const double enough_m = std::min(NavigationFunction::narrow_m, navigation_.clearance_at(p_OR));
  constexpr int half = NavigationFunction::size / 2;
  for (int k = -half; k < half; k += place_every) {
    for (int l = -half; l < half; l += place_every) {
      const Eigen::Vector2d p_O = p_OR + NavigationFunction::block_m * Eigen::Vector2d(k, l);
      if (navigation_.clearance_at(p_O) < enough_m || (p_O - p_OR).norm() < nearest_place_m) continue;
      const double way_m = navigation_.cost_at(p_O);
      if (!(way_m < farthest_place_m)) continue;
      const double score = (viewed.new_from_m2(p_O, grid) + known_m2) / (way_m + look_m);
      if (score <= best) continue;
      best = score;
      best_place = p_O;
    }
  }
  return best_place;
}

SteeringOutput Steering::steer(const SteeringInput& input, const OccupancyGrid& grid,
                               const ShieldVerdict& last) {
  if (steps_++ % field_every == 0) {
    navigation_.update(grid, input.p_OB, input.distance_m, ball_gap_m, input.time_s);
  }
  if (recovery_ == Recovery::none && is_stuck(input, last)) {
    if (last.blocked && stuck_count_ > 0) {
      navigation_.add_virtual(OccupancyGrid::center_m(last.blocked->column),
                              OccupancyGrid::center_m(last.blocked->row), input.time_s);
    }
    const double away_m = std::hypot(input.pose.x_m - stuck_at_.x_m, input.pose.y_m - stuck_at_.y_m);
    stuck_count_ = away_m < 0.3 ? stuck_count_ + 1 : 1;
    stuck_at_ = input.pose;
    const Recovery first[] = {Recovery::look_left, Recovery::back_up, Recovery::look_far};
    begin(first[(stuck_count_ - 1) % 3], input);
  }
  SteeringOutput output = recovery_ != Recovery::none ? recover(input) : SteeringOutput{};
  if (recovery_ != Recovery::none) return output;

  const Eigen::Vector2d p_OR(input.pose.x_m, input.pose.y_m), to_ball = input.p_OB - p_OR;
  const double range_m = to_ball.norm();
  const Eigen::Vector2d p_goal = input.p_OB - to_ball * (input.distance_m / std::max(range_m, 1e-6));
  const bool near = range_m < input.distance_m + 0.15;
  if (input.law && (near || navigation_.straight(p_OR, p_goal))) {
    output.command = *input.law;
    output.by_law = true;
    output.reason = "the way is clear: driving by the law";
    const double excess = std::max(1.0, std::abs(output.command.v_mps) / speed_mps);
    output.command = {output.command.v_mps / excess, output.command.w_radps / excess};
  } else {
    output = gap(input);
  }
  if (!near) output.command = keep_clear(output.command, input, grid);
  return output;
}

SteeringOutput Steering::gap(const SteeringInput& input) {
  SteeringOutput output;
  const Eigen::Vector2d p_OR(input.pose.x_m, input.pose.y_m), to_ball = input.p_OB - p_OR;
  const auto heading = navigation_.heading(input.pose, std::atan2(to_ball.y(), to_ball.x()), half_view_rad_);
  if (!heading) {
    output.reason = "dead end: no way to the ball";
    return output;
  }
  output.reason = "something is in the way: steering through a gap";
  const double aside = wrap_angle(*heading - input.when_it_acts.pose.yaw_rad);
  output.command.w_radps = std::clamp(turn_gain_per_s * aside, -turn_radps, turn_radps);
  const double clearance_m = std::max(0.0, navigation_.clearance_at(p_OR) - 0.2);
  const double speed = std::min(speed_mps, 0.25 + 0.7 * clearance_m);
  output.command.v_mps = speed * std::clamp(1.0 - std::abs(aside) / sharp_rad, 0.0, 1.0);
  return output;
}

/// The command nearest to the wanted one that closes in on nothing suspected faster than braking allows
/// (control barrier function h = distance - margin: dh/dt >= -sqrt(2 a h); Ames and others, "Control barrier
/// functions: theory and applications", ECC 2019), and keeps the ball in the picture where that is possible.
Twist2 Steering::keep_clear(const Twist2& wanted, const SteeringInput& input,
                            const OccupancyGrid& grid) const {
  // The nearest suspected block of each of sixteen directions.
  std::array<Eigen::Vector2d, 16> nearest;
  std::array<double, 16> distance_m;
  distance_m.fill(barrier_m);
  const Pose2& pose = input.when_it_acts.pose;
  const int column = static_cast<int>(std::floor(pose.x_m / NavigationFunction::block_m));
  const int row = static_cast<int>(std::floor(pose.y_m / NavigationFunction::block_m));
  constexpr int reach = static_cast<int>(barrier_m / NavigationFunction::block_m) + 1;
  for (int r = row - reach; r <= row + reach; ++r) {
    for (int c = column - reach; c <= column + reach; ++c) {
      if (!grid.is_block_suspected(c, r)) continue;
      const Eigen::Vector2d p_O((c + 0.5) * NavigationFunction::block_m,
                                (r + 0.5) * NavigationFunction::block_m);
      if ((p_O - input.p_OB).norm() < ball_gap_m) continue;
      const Eigen::Vector2d p_R = in_robot_frame(pose, p_O);
      const double away_m = p_R.norm();
      const auto sector = static_cast<std::size_t>((std::atan2(p_R.y(), p_R.x()) + M_PI) * 2.546479) % 16;
      if (away_m >= distance_m[sector]) continue;
      distance_m[sector] = away_m;
      nearest[sector] = p_R;
    }
  }

  BarrierProblem problem;
  problem.wanted = {wanted.v_mps, wanted.w_radps};
  problem.weight = {1.0, 0.15};
  for (std::size_t k = 0; k < nearest.size(); ++k) {
    if (distance_m[k] >= barrier_m) continue;
    const Eigen::Vector2d& p = nearest[k];
    const Eigen::Vector2d on_body(std::clamp(p.x(), -footprint_.rear_m, footprint_.front_m),
                                  std::clamp(p.y(), -footprint_.half_width_m, footprint_.half_width_m));
    const Eigen::Vector2d away = p - on_body;
    const double gap_m = away.norm();
    if (gap_m < 1e-6) continue;
    const Eigen::Vector2d n = away / gap_m;
    // A resting point moves by (-v + w y, -w x) in the robot frame; the gap by n times that.
    const double h_m = gap_m - margin_m;
    const double closing = h_m > 0.0 ? braking_speed(h_m, limits_.a_max_mps2, braking_share) : 0.5 * h_m;
    problem.add({{n.x(), n.y() * p.x() - n.x() * p.y()}, closing});
  }
  problem.add({{0, 1}, limits_.w_max_radps});
  problem.add({{0, -1}, limits_.w_max_radps});
  const Eigen::Vector2d p_RB = in_robot_frame(pose, input.p_OB);
  const double bearing = std::atan2(p_RB.y(), p_RB.x());
  if (std::abs(bearing) < half_view_rad_ + 0.2) {
    // d bearing / dt = -w + v sin(bearing) / range; outwards it may grow until the edge of the view.
    const double side = bearing < 0.0 ? -1.0 : 1.0;
    const double inside_rad = half_view_rad_ - std::abs(bearing);
    problem.soft =
        LinearBound{{side * std::sin(bearing) / std::max(p_RB.norm(), 0.1), -side}, 1.5 * inside_rad};
    problem.slack_weight = 0.02;
  }
  const auto command = solve(problem);
  if (!command) return {0.0, wanted.w_radps};
  // Never backwards because of a wish to go ahead.
  const double v = wanted.v_mps >= 0.0 ? std::clamp(command->x(), 0.0, wanted.v_mps) : command->x();
  return {v, command->y()};
}

/// Stuck: something was wanted, and for a while nothing came of it.
bool Steering::is_stuck(const SteeringInput& input, const ShieldVerdict& last) {
  const bool near_goal =
      (input.p_OB - Eigen::Vector2d(input.pose.x_m, input.pose.y_m)).norm() < input.distance_m + 0.02;
  if (moves(input.when_it_acts.twist) || moving_s_ < 0.0 || (last.passed && near_goal))
    moving_s_ = input.time_s;
  return input.time_s - moving_s_ > stuck_s;
}

void Steering::begin(Recovery recovery, const SteeringInput& input) {
  recovery_ = recovery;
  recovery_since_s_ = recovery_moving_s_ = input.time_s;
  recovery_yaw_rad_ = input.pose.yaw_rad;
}

SteeringOutput Steering::recover(const SteeringInput& input) {
  const double in_it_s = input.time_s - recovery_since_s_;
  if (moves(input.when_it_acts.twist)) recovery_moving_s_ = input.time_s;
  const bool stands = input.time_s - recovery_moving_s_ > standing_s;  // the shield does not let it
  const double turned = wrap_angle(input.pose.yaw_rad - recovery_yaw_rad_);
  const double moved_m = std::hypot(input.pose.x_m - stuck_at_.x_m, input.pose.y_m - stuck_at_.y_m);
  SteeringOutput output;
  output.stuck = true;
  Recovery next = Recovery::none;
  double most_s = recovery_s;
  bool done = true;
  switch (recovery_) {
    case Recovery::look_left:
      output.reason = "blocked: looking around";
      output.command.w_radps = recovery_turn_radps;
      done = turned > small_turn_rad;
      next = Recovery::look_right;
      break;
    case Recovery::look_right:
      output.reason = "blocked: looking around";
      output.command.w_radps = -recovery_turn_radps;
      done = turned < -2.0 * small_turn_rad;
      break;
    case Recovery::back_up:
      output.reason = "blocked: backing up";
      output.command.v_mps = -recovery_back_mps;
      done = moved_m > back_up_m;
      break;
    case Recovery::look_far:
      output.reason = "dead end: turning to look for a way";
      output.command.w_radps = (stuck_count_ % 2 == 0 ? -1.0 : 1.0) * recovery_turn_radps;
      done = std::abs(turned) > far_turn_rad;
      most_s = 2.0 * recovery_s;
      break;
    case Recovery::none:
      break;
  }
  if (done || stands || in_it_s > most_s) begin(next, input);
  if (recovery_ == Recovery::none) moving_s_ = input.time_s;
  return output;
}

}  // namespace ballservo
