#include "servo/simulation/world/rolling_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballservo {
namespace {

constexpr int max_bounces = 10000;

/// Time (s) after which a way (m) is done that begins at `speed` and slows down by `friction`; infinite where
/// it stands before.
double time_for(double way, double speed, double friction) {
  if (friction <= 0) return speed > 0 ? way / speed : std::numeric_limits<double>::infinity();
  const double under_root = speed * speed - 2 * friction * way;
  if (under_root < 0) return std::numeric_limits<double>::infinity();
  return 2 * way / (speed + std::sqrt(under_root));
}

}  // namespace

Eigen::Vector2d RollingMotion::place(const Eigen::Vector2d& start_m, double time_s) const {
  Eigen::Vector2d p = start_m, v = velocity_mps;
  double left_s = time_s - start_s;
  for (int bounce = 0; bounce < max_bounces && left_s > 0; ++bounce) {
    const double speed = v.norm();
    if (!(speed > 1e-9)) return p;
    const Eigen::Vector2d along = v / speed;
    double way_m = std::numeric_limits<double>::infinity();
    int axis = 0;
    for (int k = 0; k < 2; ++k) {
      if (along[k] == 0) continue;
      const double to_wall_m = std::max(0.0, ((along[k] > 0 ? high_m : low_m)[k] - p[k]) / along[k]);
      if (to_wall_m < way_m) {
        way_m = to_wall_m;
        axis = k;
      }
    }
    const double wall_s = time_for(way_m, speed, friction_mps2);
    const double stands_s =
        friction_mps2 > 0 ? speed / friction_mps2 : std::numeric_limits<double>::infinity();
    const double step_s = std::min({left_s, wall_s, stands_s});
    p += along * (speed * step_s - 0.5 * friction_mps2 * step_s * step_s);
    if (!(wall_s <= left_s && wall_s <= stands_s)) return p;
    v = along * (speed - friction_mps2 * step_s);
    v[axis] *= -restitution;
    left_s -= step_s;
  }
  return p;
}

}  // namespace ballservo
