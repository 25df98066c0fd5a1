#include "servo/avoidance/steering.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "servo/motion/unicycle.hpp"

namespace ballservo {

namespace {
constexpr double saves_share = 0.85;  // of the old way's cost
constexpr double same_goal_m = 0.3;
// Places to look from: every so many blocks, no nearer and no longer a way than this. A look costs the time
// of so much of way. Where all was seen, a place is worth a little: from there the map may show more.
constexpr int place_every = 3;
constexpr double nearest_place_m = 0.4, farthest_place_m = 12.0, look_m = 3.0, known_m2 = 0.05;
constexpr double law_gap_m = 0.20;  // beside the body, where the law drives straight
constexpr double ahead_m = 0.20, least_ahead_m = 0.25, most_ahead_m = 0.60;  // of pursuit, and the gap
constexpr double there_m = 0.09;                          // 3/4 of a block: a pose so near is turned at
constexpr double speed_mps = 0.6, most_turn_radps = 1.0;  // at most, among obstacles
constexpr double slow_mps = 0.05;                         // no slower ahead at a way's end
constexpr double turn_gain_per_s = 2.2;
constexpr double sharp_rad = 0.7;      // a heading further aside is turned to on the spot
constexpr double braking_share = 0.6;  // of the drive's deceleration that the barrier counts on
constexpr double stuck_s = 0.8;        // so long without motion that was wanted: stuck
constexpr double ball_gap_m = 0.25;    // echoes so near the ball are the ball's
constexpr double barrier_m = 1.0;      // what is further from the axle does not bound the command
constexpr double small_turn_rad = 0.30, far_turn_rad = 1.4, back_up_m = 0.25;
constexpr double recovery_turn_radps = 0.6, recovery_back_mps = 0.15, recovery_s = 2.5;
constexpr double standing_s = 0.5;  // a recovery that moves nothing for so long gives way to the next

// What was refused is taken to lie so far ahead, a radian of turn as so much of way; it is avoided so long.
constexpr double refused_ahead_m = 0.15, refused_turn_m_per_rad = 0.5, refused_s = 30.0;

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
      const double det = cross(p.a, r.a);
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
    : half_view_rad_(half_view_rad), limits_(limits), footprint_(footprint), navigation_(footprint) {}

Eigen::Vector2d Steering::place_to_look_from(const ObstacleMap& map, const OccupancyGrid& grid,
                                             const ViewedFloor& viewed) {
  const Eigen::Vector2d p_OR(grid.pose().x_m, grid.pose().y_m);
  const Eigen::Vector2d beyond = p_OR + Eigen::Vector2d(1e3, 1e3);  // costs are wanted of all the window
  navigation_.update(map, grid, beyond, p_OR, 0.0, 0.0);
  Eigen::Vector2d best_place = p_OR;
  double best = 0.0;
  const double enough_m = std::min(footprint_.reach_m() + 0.1, navigation_.clearance_m(p_OR));
  for (int row = 0; row < NavigationFunction::size; row += place_every) {
    for (int column = 0; column < NavigationFunction::size; column += place_every) {
      const Eigen::Vector2d p_O = navigation_.center_m({column, row});
      if (navigation_.clearance_m(p_O) < enough_m || (p_O - p_OR).norm() < nearest_place_m) continue;
      const double way_m = navigation_.cost_m({column, row});
      if (!(way_m < farthest_place_m)) continue;
      const double score =
          (viewed.unseen_from({p_O.x(), p_O.y()}, map).area_m2 + known_m2) / (way_m + look_m);
      if (score <= best) continue;
      best = score;
      best_place = p_O;
    }
  }
  return best_place;
}

SteeringOutput Steering::steer(const SteeringInput& input, const ObstacleMap& map, const OccupancyGrid& grid,
                               const ShieldVerdict& last) {
  const bool elsewhere = (input.p_OB - planned_to_).norm() > same_goal_m;
  if (steps_++ % plan_every == 0 || elsewhere) {
    plan(input, map, grid);
    planned_to_ = input.p_OB;
  }
  if (recovery_ == Recovery::none && is_stuck(input, last)) {
    stuck_count_ = distance_m(stuck_at_, input.pose) < 0.3 ? stuck_count_ + 1 : 1;
    stuck_at_ = input.pose;
    remember_refused(input);
    const Recovery first[] = {Recovery::look_left, Recovery::back_up, Recovery::look_far};
    begin(first[(stuck_count_ - 1) % 3], input);
  }
  SteeringOutput output = recovery_ != Recovery::none ? recover(input) : SteeringOutput{};
  if (recovery_ != Recovery::none) return output;

  const Eigen::Vector2d p_OR(input.pose.x_m, input.pose.y_m), to_ball = input.p_OB - p_OR;
  const double range_m = to_ball.norm();
  const Eigen::Vector2d p_goal = input.p_OB - to_ball * (input.distance_m / std::max(range_m, 1e-6));
  const bool near = range_m < input.distance_m + 0.03;
  if (input.law && (near || navigation_.straight(p_OR, p_goal, law_gap_m))) {
    output.command = *input.law;
    output.reason = "the way is clear: driving by the law";
    const double excess = std::max(1.0, std::abs(output.command.v_mps) / speed_mps);
    output.command = {output.command.v_mps / excess, output.command.w_radps / excess};
  } else {
    output = follow(input);
  }
  if (!near) output.command = keep_clear(output.command, input, map);
  wanted_ = output.command;
  return output;
}

/// A new way where there is none, where the old one has become worse, or where it saves a good deal: else the
/// robot would waver between two that are as good.
void Steering::plan(const SteeringInput& input, const ObstacleMap& map, const OccupancyGrid& grid) {
  const bool to_ball = input.distance_m > 0.0;
  navigation_.update(map, grid, {input.pose.x_m, input.pose.y_m}, input.p_OB, input.distance_m,
                     to_ball ? ball_gap_m : 0.0);
  const WayRequest request{input.time_s, input.when_it_acts.pose, input.p_OB, to_ball ? half_view_rad_ : 0.0,
                           refused_};
  const bool found = planner_.plan(navigation_, request, new_way_);
  const double old_m = planner_.cost_m(navigation_, request, way_);
  if (found && new_way_.cost_m <= saves_share * old_m) {
    way_ = new_way_;
  } else if (!std::isfinite(old_m)) {
    way_.count = 0;
  }
}

/// Pure pursuit (Coulter, CMU-RI-TR-92-01) of a pose ahead on the way, the nearer the narrower it is.
SteeringOutput Steering::follow(const SteeringInput& input) {
  SteeringOutput output;
  if (way_.count == 0) {
    output.reason = "dead end: no way to the ball";
    output.no_way = true;
    return output;
  }
  output.reason = "something is in the way: driving around it";
  const Pose2& pose = input.when_it_acts.pose;
  const double gap_m = std::max(0.0, navigation_.gap_m(pose));
  const double pursued_m = std::clamp(ahead_m + gap_m, least_ahead_m, most_ahead_m);
  // The nearest pose of the way, then on until it is far enough ahead or the robot turns on the spot.
  const auto away_m = [&](std::size_t k) { return distance_m(pose, way_.poses[k]); };
  std::size_t at = 0;
  for (std::size_t k = 1; k < way_.count; ++k) {
    if (away_m(k) <= away_m(at) + 1e-9) at = k;
  }
  std::size_t next = at;
  const auto moves_astern = [&](std::size_t k) {
    const Pose2 &from = way_.poses[k], &to = way_.poses[k + 1];
    return (to.x_m - from.x_m) * std::cos(from.yaw_rad) + (to.y_m - from.y_m) * std::sin(from.yaw_rad) <
           -1e-9;
  };
  const bool astern = at + 1 < way_.count && moves_astern(at);
  while (next + 1 < way_.count && away_m(next) < pursued_m && moves_astern(next) == astern) ++next;
  double aside, left_m = away_m(next);
  if (left_m < there_m) {
    aside = wrap_angle(way_.poses[next].yaw_rad - pose.yaw_rad);
    left_m = 0.0;
  } else {
    aside = wrap_angle(std::atan2(way_.poses[next].y_m - pose.y_m, way_.poses[next].x_m - pose.x_m) -
                       pose.yaw_rad + (astern ? M_PI : 0.0));
  }
  output.command.w_radps = std::clamp(turn_gain_per_s * aside, -most_turn_radps, most_turn_radps);
  double speed = astern ? recovery_back_mps : std::min(speed_mps, 0.25 + 0.7 * gap_m);
  if (input.distance_m > 0.0) {  // to rest at the way's end
    double to_end_m = away_m(at);
    for (std::size_t k = at; k + 1 < way_.count; ++k)
      to_end_m += distance_m(way_.poses[k], way_.poses[k + 1]);
    speed = std::min(speed, std::max(slow_mps, braking_speed(to_end_m, limits_.a_max_mps2, braking_share)));
  }
  const double v = left_m > 0.0 ? speed * std::clamp(1.0 - std::abs(aside) / sharp_rad, 0.0, 1.0) : 0.0;
  output.command.v_mps = astern ? -v : v;
  return output;
}

/// The command nearest to the wanted one that closes in on nothing occupied faster than braking allows
/// (control barrier function h = distance - margin: dh/dt >= -sqrt(2 a h); Ames and others, "Control barrier
/// functions: theory and applications", ECC 2019), and keeps the ball in the picture where that is possible.
Twist2 Steering::keep_clear(const Twist2& wanted, const SteeringInput& input, const ObstacleMap& map) const {
  // The nearest occupied cell of each of sixteen directions.
  std::array<Eigen::Vector2d, 16> nearest;
  std::array<double, 16> distance_m;
  distance_m.fill(barrier_m);
  const Pose2& pose = input.when_it_acts.pose;
  const FloorCell at = ObstacleMap::cell_at(pose.x_m, pose.y_m);
  constexpr int reach = static_cast<int>(barrier_m / ObstacleMap::cell_m) + 1;
  for (int row = at.row - reach; row <= at.row + reach; ++row) {
    for (int column = at.column - reach; column <= at.column + reach; ++column) {
      if (map.probability({column, row}) < ObstacleMap::occupied) continue;
      const Eigen::Vector2d p_O = ObstacleMap::center_m({column, row});
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

/// The pose that was wanted next will be no better in a while: it costs more for some time.
void Steering::remember_refused(const SteeringInput& input) {
  const double rate_mps = std::abs(wanted_.v_mps) + refused_turn_m_per_rad * std::abs(wanted_.w_radps);
  if (rate_mps < 1e-6) return;
  const Pose2 next = integrate(input.pose, wanted_, refused_ahead_m / rate_mps);
  refused_[next_refused_] = {next, input.time_s + refused_s};
  next_refused_ = (next_refused_ + 1) % refused_.size();
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
      done = distance_m(stuck_at_, input.pose) > back_up_m;
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
