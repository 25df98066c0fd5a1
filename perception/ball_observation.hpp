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
/// So it is as two classes, where both are as large and in one place.
inline bool same_ball(const BallObservation& a, const BallObservation& b) {
  const double larger_rad = std::max(a.cone.alpha_rad, b.cone.alpha_rad);
  const double apart = angle_between(a.cone.axis, b.cone.axis) / larger_rad;
  if (a.color_class == b.color_class) return apart < 0.7;
  return apart < 0.2 && std::min(a.cone.alpha_rad, b.cone.alpha_rad) > 0.8 * larger_rad;
}

}  // namespace ballservo
