// Trials of a sweep, drawn from above.
#pragma once

#include <vector>

#include "app/report/svg.hpp"
#include "app/sweep/trial.hpp"

namespace ballservo {

/// A trial's way and whether it reached the ball.
struct DrawnTrial {
  TrialTrace trace;
  bool reached = false;
};

/// All ways over one another: those that failed stand out. Obstacles are drawn where all trials share them.
Svg ways_drawing(const std::vector<DrawnTrial>& trials);

/// One trial in its own room.
Svg way_drawing(const DrawnTrial& trial, double goal_distance_m, int width_px);

}  // namespace ballservo
