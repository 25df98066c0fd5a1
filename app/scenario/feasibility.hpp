// Whether a scenario's task can be done at all: worlds that cannot are counted apart.
#pragma once

#include <string>

#include "app/scenario/scenario.hpp"

namespace ballservo {

struct Feasibility {
  bool feasible = true;
  std::string reason;  ///< why not, for people; empty where it is
};

/// Feasible: PathPlanner brings the robot (its holding disc and `margin_m` around it) from its start to a
/// place from which it sees the ball at the desired distance; for a ball that moves, at every second of the
/// run. A sufficient proof: what it calls infeasible may still be possible.
Feasibility check_feasible(const Scenario& scenario, double margin_m = 0.10);

}  // namespace ballservo
