#include "servo/simulation/robot/unicycle_robot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

namespace {
constexpr double longest_step_s = 1e-3;
}

UnicycleRobot::UnicycleRobot(const Pose2& start, const UnicycleLimits& limits, double actuation_delay_s)
    : pose_(start), limits_(limits), delay_s_(actuation_delay_s) {
  // Any drive can be simulated, a share of the limits or a drive without any among them.
  for (const double limit :
       {limits_.v_max_mps, limits_.w_max_radps, limits_.a_max_mps2, limits_.alpha_max_radps2}) {
    if (!(std::isfinite(limit) && limit > 0))
      throw InputError("limits", fmt::format("{}", limit), "numbers above 0");
  }
  if (!(std::isfinite(delay_s_) && delay_s_ >= 0)) {
    throw InputError("actuation_delay_s",
                     std::isfinite(delay_s_) ? number_text(delay_s_) : "not a finite number",
                     "a number from 0 (s)");
  }
}

void UnicycleRobot::command(const Twist2& twist) {
  const bool finite = std::isfinite(twist.v_mps) && std::isfinite(twist.w_radps);
  pending_.push_back({time_s_ + delay_s_, finite ? twist : Twist2{}});
}

void UnicycleRobot::advance_to(double time_s) {
  while (!pending_.empty() && pending_.front().time_s <= time_s) {
    drive(pending_.front().time_s);
    followed_ = pending_.front().twist;
    pending_.pop_front();
  }
  drive(time_s);
}

void UnicycleRobot::drive(double until_s) {
  const double span_s = until_s - time_s_;
  if (!(span_s > 0)) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(span_s / longest_step_s - 1e-9)));
  const double dt_s = span_s / steps;
  for (int k = 0; k < steps; ++k) {
    const Twist2 next = limit_acceleration(twist_, followed_, limits_, dt_s);
    pose_ =
        integrate(pose_, {0.5 * (twist_.v_mps + next.v_mps), 0.5 * (twist_.w_radps + next.w_radps)}, dt_s);
    twist_ = next;
  }
  time_s_ = until_s;
}

}  // namespace ballservo
