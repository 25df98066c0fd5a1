// Teaching by showing: the robot stands at the goal, looks, and remembers what it saw.
#pragma once

#include <functional>

#include "app/experiment/simulated_perception.hpp"
#include "app/scenario/scenario.hpp"
#include "app/scenario/taught_target.hpp"

namespace ballservo {

struct TeachOptions {
  PerceptionLevel perception = PerceptionLevel::image;
  std::uint64_t seed = 0;
  std::shared_ptr<const ColorTable> colors;  ///< for level image
  int frames = 60;                           ///< looked at; the tracker takes the first to confirm the ball
  std::function<void(int done)> progress;    ///< called before each frame; what it throws ends the teaching
};

/// Puts the robot at the scenario's target distance from where the ball is at time 0, facing it, on the line
/// from its start, and looks; a ball that moves stands. Throws Refusal where something is in the way there,
/// or the ball is confirmed in less than half of the frames.
TaughtTarget teach_target(const Scenario& scenario, const TeachOptions& options);

}  // namespace ballservo
