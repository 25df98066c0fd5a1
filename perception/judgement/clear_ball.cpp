#include "perception/judgement/clear_ball.hpp"

#include "perception/judgement/ball_judge.hpp"

namespace ballservo {
namespace {

constexpr double least_clear_shading = 0.4, most_flat_shading = 0.1;
// Three times the look-alikes by size that are allowed for where no ball is clear. Of 70 whole balls of 4 to
// 12 px radius beside clear ones, all that are seen as such are above; of round leaves, most are below.
constexpr double least_small_log_odds = 3, size_weight = 3;

}  // namespace

bool may_be_clear_ball(const BallLooks& looks) {
  return looks.radius_px >= small_ball_px && looks.shading_strength >= least_clear_shading;
}

bool is_flat_disc(const BallLooks& looks) {
  return looks.radius_px >= small_ball_px && looks.shading_strength < most_flat_shading;
}

double least_log_odds_of_small(double radius_px) {
  return least_small_log_odds + size_weight * log_look_alikes_by_size(radius_px);
}

}  // namespace ballservo
