// How the robot gets to the ball among obstacles: straight by the law where the way is clear, else along a
// planned way; and what it does where it is stuck.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "servo/avoidance/braking_shield.hpp"
#include "servo/avoidance/navigation_function.hpp"
#include "servo/avoidance/viewed_floor.hpp"
#include "servo/avoidance/way_planner.hpp"

namespace ballservo {

/// a . u <= b.
struct LinearBound {
  Eigen::Vector2d a{0, 0};
  double b = 0;
};

/// A quadratic programme in two variables: the command nearest to the wanted one that keeps its distance.
/// minimise  (u - wanted)^T diag(weight) (u - wanted) + slack_weight * max(0, soft.a . u - soft.b)^2
/// subject to bounds[k].a . u <= bounds[k].b
struct BarrierProblem {
  static constexpr std::size_t max_bounds = 24;
  Eigen::Vector2d wanted{0, 0}, weight{1, 1};
  std::array<LinearBound, max_bounds> bounds;
  std::size_t count = 0;
  std::optional<LinearBound> soft;
  double slack_weight = 0;

  /// More than fit are dropped: the shield has the last word.
  void add(const LinearBound& bound) {
    if (count < max_bounds) bounds[count++] = bound;
  }
};

/// The minimiser, by enumeration of the active sets: none, each one, each pair (Nocedal and Wright,
/// "Numerical Optimization", 16.1), once with the soft bound kept and once with it left. Nothing where no
/// point keeps all bounds, or an input is not finite. Allocates nothing.
std::optional<Eigen::Vector2d> solve(const BarrierProblem& problem);

/// What steering is told.
struct SteeringInput {
  double time_s = 0;
  Pose2 pose;  ///< in the odometry's frame, as are all places here
  RobotMotion when_it_acts;
  Eigen::Vector2d p_OB{0, 0};  ///< the ball, as known or remembered
  double distance_m = 0.8;     ///< the desired one
  std::optional<Twist2> law;   ///< what the law asks for; nothing where it has no answer or sees no ball
};

struct SteeringOutput {
  Twist2 command;
  bool stuck = false;       ///< a recovery is under way
  bool no_way = false;      ///< to where it is to go
  std::string_view reason;  ///< a literal
};

class Steering {
 public:
  /// The barrier keeps this from what stands, if it can: what the shield asks for, and the cell's half
  /// diagonal.
  static constexpr double margin_m = 0.10;
  /// A way is planned once in so many steps.
  static constexpr unsigned plan_every = 5;

  /// `half_view_rad`: the ball further aside is out of the picture of a camera that looks ahead.
  Steering(double half_view_rad, const UnicycleLimits& limits, const Footprint& footprint);

  /// `last`: what became of the command before.
  SteeringOutput steer(const SteeringInput& input, const ObstacleMap& map, const OccupancyGrid& grid,
                       const ShieldVerdict& last);

  /// The place from which a turn shows the most floor for the way there; the robot's own where there is none.
  Eigen::Vector2d place_to_look_from(const ObstacleMap& map, const OccupancyGrid& grid,
                                     const ViewedFloor& viewed);

  /// The state changed: whatever recovery was under way is over.
  void reset() {
    recovery_ = Recovery::none;
    moving_s_ = -1;
  }

 private:
  /// What is tried, one after the other, when the robot is stuck.
  enum class Recovery { none, look_left, look_right, back_up, look_far };
  void plan(const SteeringInput& input, const ObstacleMap& map, const OccupancyGrid& grid);
  SteeringOutput follow(const SteeringInput& input);
  SteeringOutput recover(const SteeringInput& input);
  bool is_stuck(const SteeringInput& input, const ShieldVerdict& last);
  void remember_refused(const SteeringInput& input);
  void begin(Recovery recovery, const SteeringInput& input);
  Twist2 keep_clear(const Twist2& wanted, const SteeringInput& input, const ObstacleMap& map) const;

  double half_view_rad_;
  UnicycleLimits limits_;
  Footprint footprint_;
  NavigationFunction navigation_;
  WayPlanner planner_;
  Way way_, new_way_;
  Eigen::Vector2d planned_to_{0, 0};
  std::array<RefusedPose, 8> refused_{};  // a ring
  std::size_t next_refused_ = 0;
  Twist2 wanted_;  // in the step before
  unsigned steps_ = 0;
  double moving_s_ = -1;  // when it last did what was wanted
  Recovery recovery_ = Recovery::none;
  double recovery_since_s_ = 0, recovery_yaw_rad_ = 0;
  double recovery_moving_s_ = 0;  // when it last moved
  Pose2 stuck_at_;
  int stuck_count_ = 0;
};

}  // namespace ballservo
