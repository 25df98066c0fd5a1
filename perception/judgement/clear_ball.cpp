#include "perception/judgement/clear_ball.hpp"

#include "perception/judgement/ball_judge.hpp"

namespace ballservo {
namespace {

constexpr double least_clear_log_odds = 15, least_clear_shading = 0.4;
constexpr double most_flat_shading = 0.1;
// Three times the look-alikes by size that are allowed for where no ball is clear. Of 70 whole balls of 4 to
// 12 px radius beside clear ones, all that are seen as such are above; of round leaves, most are below.
constexpr double least_small_log_odds = 3, size_weight = 3;

}  // namespace

bool is_clear_ball(const BallLooks& looks) {
  return looks.radius_px >= small_ball_px && looks.look.log_odds >= least_clear_log_odds &&
         looks.shading.strength >= least_clear_shading;
}

const char* reason_beside_clear_ball(const BallLooks& looks) {
  const bool small = looks.radius_px < small_ball_px;
  if (!small && looks.shading.strength < most_flat_shading)
    return "evenly bright, beside a ball that is shaded";
  const double least = least_small_log_odds + size_weight * log_look_alikes_by_size(looks.radius_px);
  if (small && looks.look.log_odds < least) return "a speck, beside a clear ball";
  return nullptr;
}

}  // namespace ballservo
