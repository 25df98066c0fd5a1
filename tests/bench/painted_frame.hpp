// Accuracy frames painted without the simulator's renderer: nothing that is measured may lean on what only
// that one does.
//
// A layered picture in linear light: background of gradients, waves and shapes; the ball traced with 64 rays
// a pixel through the camera's own model, with a soft terminator, optional highlight, marbling and half
// shade; an occluder; then blur, response, noise.
#pragma once

#include "calibration/base/random.hpp"
#include "tests/bench/accuracy_condition.hpp"

namespace ballservo::bench {

AccuracyFrame painted_frame(const AccuracyCondition& condition, RandomEngine& engine);

}  // namespace ballservo::bench
