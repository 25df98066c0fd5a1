// A ball as it was seen in one picture.
#pragma once

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

}  // namespace ballservo
