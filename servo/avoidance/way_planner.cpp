#include "servo/avoidance/way_planner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr float unreached_m = std::numeric_limits<float>::infinity();
constexpr std::size_t most_expanded = 6000, most_waiting = 65536;

// Costs in metres on open floor.
constexpr double turn_m_per_rad = 0.35;  // on the spot
constexpr double astern_cost = 2.5;      // times as much as ahead: slower, and nobody looks
constexpr double facing_rad = 0.25;      // a way ends no further aside of the ball
constexpr double unseen_cost = 1.0;      // so much more while the ball is out of the picture
// Where the robot is too near to something already: so much, and more for each metre of gap that is missing.
constexpr double leaving_price = 12.0, leaving_per_m = 8.0;

// For each time that the shield refused a pose so near, a metre costs so much more.
constexpr double refused_m = 0.15, refused_rad = 0.4, refused_price = 60.0;

/// Steps in blocks along each heading; heading k lies at the angle of its step.
constexpr int steps[WayPlanner::headings][2] = {{1, 0},  {2, 1},  {1, 1},  {1, 2},   {0, 1},   {-1, 2},
                                                {-1, 1}, {-2, 1}, {-1, 0}, {-2, -1}, {-1, -1}, {-1, -2},
                                                {0, -1}, {1, -2}, {1, -1}, {2, -1}};

double angle_of(int heading) {
  static const auto angles_rad = [] {
    std::array<double, WayPlanner::headings> angles{};
    for (std::size_t k = 0; k < angles.size(); ++k) angles[k] = std::atan2(steps[k][1], steps[k][0]);
    return angles;
  }();
  return angles_rad[static_cast<std::size_t>(heading)];
}

int nearest_heading(double yaw_rad) {
  int best = 0;
  for (int k = 1; k < WayPlanner::headings; ++k) {
    if (std::abs(wrap_angle(yaw_rad - angle_of(k))) < std::abs(wrap_angle(yaw_rad - angle_of(best))))
      best = k;
  }
  return best;
}

/// How far the ball is aside of straight ahead.
double ball_aside_rad(const WayRequest& request, const Pose2& pose) {
  const double bearing_rad = std::atan2(request.p_OB.y() - pose.y_m, request.p_OB.x() - pose.x_m);
  return std::abs(wrap_angle(bearing_rad - pose.yaw_rad));
}

constexpr std::int32_t way_states =
    NavigationFunction::size * NavigationFunction::size * WayPlanner::headings;

std::int32_t state_of(const NavigationFunction::Block& block, int heading) {
  return static_cast<std::int32_t>(NavigationFunction::index(block)) * WayPlanner::headings + heading;
}
NavigationFunction::Block block_of(std::int32_t state) {
  const std::int32_t cell = state / WayPlanner::headings;
  return {cell % NavigationFunction::size, cell / NavigationFunction::size};
}
Pose2 pose_of(const NavigationFunction& navigation, std::int32_t state) {
  const Eigen::Vector2d p = navigation.center_m(block_of(state));
  return {p.x(), p.y(), angle_of(state % WayPlanner::headings)};
}

}  // namespace

WayPlanner::WayPlanner() : nodes_(static_cast<std::size_t>(way_states)) { heap_.reserve(most_waiting); }

WayPlanner::Price WayPlanner::price_at(NavigationFunction& navigation, const WayRequest& request,
                                       const Pose2& pose) {
  Price price{navigation.price(pose), 0};
  for (const RefusedPose& refused : request.refused) {
    if (refused.until_s < request.time_s) continue;
    const bool near = distance_m(refused.pose, pose) < refused_m &&
                      std::abs(wrap_angle(pose.yaw_rad - refused.pose.yaw_rad)) < refused_rad;
    if (near) price.more += refused_price;
  }
  const auto sees_ball = [&] {
    return ball_aside_rad(request, pose) <= request.half_view_rad &&
           navigation.sees_ball(navigation.block_at({pose.x_m, pose.y_m}));
  };
  if (request.half_view_rad > 0.0 && !sees_ball()) price.more += unseen_cost;
  return price;
}

/// Of one move; infinite where the body does not fit at its end, and where it started from fits better.
double WayPlanner::move_cost_m(const NavigationFunction& navigation, const Pose2& from, const Pose2& to,
                               const Price& price_there) {
  double room = price_there.room;
  if (!std::isfinite(room)) {
    const double gap_m = navigation.gap_m(to);
    if (gap_m < navigation.gap_m(from)) return infinite;
    room = leaving_price + leaving_per_m * std::max(0.0, -gap_m);
  }
  const Eigen::Vector2d way(to.x_m - from.x_m, to.y_m - from.y_m);
  double cost_m = way.norm();
  if (cost_m < 1e-6) {
    cost_m = turn_m_per_rad * std::abs(wrap_angle(to.yaw_rad - from.yaw_rad));
  } else if (way.x() * std::cos(from.yaw_rad) + way.y() * std::sin(from.yaw_rad) < 0.0) {
    cost_m *= astern_cost;
  }
  return cost_m * (room + price_there.more);
}

/// At a goal, facing the ball.
bool WayPlanner::ends(const NavigationFunction& navigation, const WayRequest& request, const Pose2& pose) {
  const NavigationFunction::Block block = navigation.block_at({pose.x_m, pose.y_m});
  if (!NavigationFunction::inside(block) || !navigation.is_goal(block)) return false;
  return request.half_view_rad <= 0.0 ||
         ball_aside_rad(request, pose) <= std::min(facing_rad, request.half_view_rad);
}

bool WayPlanner::plan(NavigationFunction& navigation, const WayRequest& request, Way& way) {
  const auto start = navigation.block_at({request.from.x_m, request.from.y_m});
  if (!NavigationFunction::inside(start)) return false;
  ++epoch_;
  heap_.clear();
  const auto node_of = [&](std::int32_t state) -> Node& {
    Node& node = nodes_[static_cast<std::size_t>(state)];
    if (node.epoch != epoch_)
      node = {price_at(navigation, request, pose_of(navigation, state)), unreached_m, -1, epoch_, false};
    return node;
  };
  const auto reach = [&](std::int32_t state, double cost_m, std::int32_t parent) {
    Node& node = node_of(state);
    if (node.closed || node.cost_m <= static_cast<float>(cost_m)) return;
    const double left_m = navigation.cost_m(block_of(state));
    if (!std::isfinite(left_m) || heap_.size() >= most_waiting) return;
    node.cost_m = static_cast<float>(cost_m);
    node.parent = parent;
    heap_.push_back({static_cast<float>(cost_m + left_m), state});
    std::push_heap(heap_.begin(), heap_.end());
  };
  reach(state_of(start, nearest_heading(request.from.yaw_rad)), 0.0, -1);
  std::int32_t end = -1, nearest = -1;
  double nearest_m = infinite;
  std::size_t expanded = 0;
  while (!heap_.empty() && expanded < most_expanded) {
    std::pop_heap(heap_.begin(), heap_.end());
    const std::int32_t state = heap_.back().state;
    heap_.pop_back();
    Node& node = nodes_[static_cast<std::size_t>(state)];
    if (node.closed) continue;
    node.closed = true;
    ++expanded;
    const NavigationFunction::Block block = block_of(state);
    const int heading = state % headings;
    const Pose2 pose = pose_of(navigation, state);
    const double left_m = navigation.cost_m(block);
    if (left_m < nearest_m) {
      nearest_m = left_m;
      nearest = state;
    }
    if (ends(navigation, request, pose)) {
      end = state;
      break;
    }
    const auto move = [&](const NavigationFunction::Block& to, int to_heading) {
      if (!NavigationFunction::inside(to)) return;
      const std::int32_t next = state_of(to, to_heading);
      const double cost_m = move_cost_m(navigation, pose, pose_of(navigation, next), node_of(next).price);
      if (std::isfinite(cost_m)) reach(next, static_cast<double>(node.cost_m) + cost_m, state);
    };
    const auto& step = steps[heading];
    const int left = (heading + 1) % headings, right = (heading + headings - 1) % headings;
    move({block.column + step[0], block.row + step[1]}, heading);
    move({block.column - step[0], block.row - step[1]}, heading);
    move(block, left);
    move(block, right);
    move({block.column + step[0], block.row + step[1]}, left);
    move({block.column + step[0], block.row + step[1]}, right);
  }
  if (end < 0 && expanded == most_expanded) end = nearest;  // as far as it was looked
  if (end < 0) return false;
  std::size_t count = 0;
  for (std::int32_t state = end; state >= 0; state = nodes_[static_cast<std::size_t>(state)].parent) ++count;
  for (; count > Way::most; --count)  // the first part will do
    end = nodes_[static_cast<std::size_t>(end)].parent;
  way.count = count;
  way.cost_m = static_cast<double>(nodes_[static_cast<std::size_t>(end)].cost_m);
  std::int32_t state = end;
  for (std::size_t k = count; k-- > 0; state = nodes_[static_cast<std::size_t>(state)].parent) {
    way.poses[k] = pose_of(navigation, state);
  }
  return true;
}

double WayPlanner::cost_m(NavigationFunction& navigation, const WayRequest& request, const Way& way) const {
  if (way.count == 0 || !ends(navigation, request, way.poses[way.count - 1])) return infinite;
  const Pose2* const end = way.poses.data() + way.count;
  const Pose2* at =
      std::min_element(way.poses.data(), end, [&from = request.from](const Pose2& a, const Pose2& b) {
        return distance_m(from, a) < distance_m(from, b);
      });
  const auto move_m = [&](const Pose2& from, const Pose2& to) {
    return move_cost_m(navigation, from, to, price_at(navigation, request, to));
  };
  // To that pose: there, then the turn.
  const Pose2 there{at->x_m, at->y_m, request.from.yaw_rad};
  double cost_m = move_m(request.from, there) + move_m(there, *at);
  for (; at + 1 < end; ++at) cost_m += move_m(at[0], at[1]);
  return cost_m;
}

}  // namespace ballservo
