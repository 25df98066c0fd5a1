// A ball as it was seen in one picture.
#pragma once

#include <algorithm>
#include <optional>

#include "calibration/circles/circle_vote.hpp"
#include "calibration/color/color_table.hpp"
#include "perception/judgement/outline_support.hpp"
#include "perception/outline/ball_fitter.hpp"

namespace ballservo {

struct BallObservation : FittedBall {
  ClassIndex color_class = no_class;
  /// What the votes said of the ball's region; nothing where it was found without them.
  std::optional<CircleEstimate> vote;
  OutlineSupport support;
  double quality = 0;  ///< 0 to 1
};

/// Whether one lies well inside the other: seen through two windows, or in two regions, a ball is still one.
inline bool same_ball(const BallObservation& a, const BallObservation& b) {
  return a.color_class == b.color_class &&
         angle_between(a.cone.axis, b.cone.axis) < 0.7 * std::max(a.cone.alpha_rad, b.cone.alpha_rad);
}

}  // namespace ballservo
