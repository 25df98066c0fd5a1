// Accuracy frames from the simulator's renderer: a shaded ball in a cluttered room, lamps from all sides.
#pragma once

#include "calibration/base/random.hpp"
#include "tests/bench/accuracy_condition.hpp"

namespace ballservo::bench {

AccuracyFrame rendered_frame(const AccuracyCondition& condition, RandomEngine& engine);

}  // namespace ballservo::bench
