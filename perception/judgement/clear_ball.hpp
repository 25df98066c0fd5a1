// What a clear ball tells of the other things of its colour in its picture. The light that shades one ball
// shades all: what is evenly bright beside it is flat. And specks are many where second balls are few.
#pragma once

#include <optional>

namespace ballservo {

/// How a supposed ball looks, without its outline's fit.
struct BallLooks {
  double radius_px = 0;
  double shading_strength = 0;     ///< see BallShading
  std::optional<double> log_odds;  ///< by a second look, which is slow: taken where it decides
};

/// So plainly a ball, if a second look gives it `least_clear_log_odds`, that others of its class can be
/// compared with it.
bool may_be_clear_ball(const BallLooks& looks);
inline constexpr double least_clear_log_odds = 15;

/// Beside a clear ball: a thing that is large and flat is none, and one so small only by these log odds.
bool is_flat_disc(const BallLooks& looks);
double least_log_odds_of_small(double radius_px);

}  // namespace ballservo
