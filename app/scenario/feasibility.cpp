#include "app/scenario/feasibility.hpp"

#include <fmt/format.h>

#include <cmath>
#include <variant>

#include "servo/simulation/world/collision.hpp"

namespace ballservo {

std::string why_infeasible(const Scenario& scenario) {
  const Ball& ball = scenario.target_ball();
  PathPlanner planner(scenario.world, scenario.robot.footprint, scenario.robot.pose);
  const bool moves = !std::holds_alternative<StaticMotion>(ball.motion);
  const double end_s = moves ? scenario.duration_s : 0.0;
  for (double time_s = 0; time_s <= end_s; time_s += 1.0) {
    if (planner.may_reach_view_of(ball.p_WB(time_s), ball.radius_m(), scenario.target_distance_m,
                                  scenario.camera.mount.up_m))
      continue;
    return fmt::format(
        "no way that the robot fits from the start to a place {} m from the ball{} that sees it",
        scenario.target_distance_m, moves ? fmt::format(" at {:.0f} s", time_s) : "");
  }
  return "";
}

double rest_to_rest_s(double way, double speed_limit, double acceleration_limit) {
  way = std::abs(way);
  const double ramps_m =
      speed_limit * speed_limit / acceleration_limit;  // covered by a full ramp up and down
  if (way <= ramps_m) return 2.0 * std::sqrt(way / acceleration_limit);
  return 2.0 * speed_limit / acceleration_limit + (way - ramps_m) / speed_limit;
}

double time_optimal_s(const Pose2& start, const Eigen::Vector2d& p_WB, double distance_m,
                      const UnicycleLimits& limits) {
  const Eigen::Vector2d p_RB = in_robot_frame(start, p_WB);
  return rest_to_rest_s(std::atan2(p_RB.y(), p_RB.x()), limits.w_max_radps, limits.alpha_max_radps2) +
         rest_to_rest_s(p_RB.norm() - distance_m, limits.v_max_mps, limits.a_max_mps2);
}

}  // namespace ballservo
