#include "app/scenario/feasibility.hpp"

#include <fmt/format.h>

#include <variant>

#include "servo/simulation/world/collision.hpp"

namespace ballservo {

Feasibility check_feasible(const Scenario& scenario, double margin_m) {
  const Ball& ball = scenario.target_ball();
  const PathPlanner planner(scenario.world, scenario.robot.footprint, margin_m, scenario.robot.pose);
  const bool moves = !std::holds_alternative<StaticMotion>(ball.motion);
  const double end_s = moves ? scenario.duration_s : 0.0;
  for (double time_s = 0; time_s <= end_s; time_s += 1.0) {
    if (planner.reaches_view_of(ball.p_WB(time_s).head<2>(), scenario.target_distance_m, ball.radius_m())) {
      continue;
    }
    return {false,
            fmt::format("no way {:.2f} m wide from the start to a place {} m from the ball{} that sees it",
                        2 * planner.disc_radius_m(), scenario.target_distance_m,
                        moves ? fmt::format(" at {:.0f} s", time_s) : "")};
  }
  return {};
}

}  // namespace ballservo
