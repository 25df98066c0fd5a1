#include "app/scenario/time_optimal.hpp"

#include <cmath>

namespace ballservo {

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
