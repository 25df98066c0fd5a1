// A run in which somebody else has the robot, the camera and the room.
#pragma once

#include "app/experiment/runner.hpp"

namespace ballservo {

/// The scenario's controller and perception drive the peer's robot to the end: the judge's word, the peer's,
/// or `options.go_on`. What is true is known as far as the peer tells it. Throws as run_closed_loop does, for
/// a robot that never came.
RunRecord drive_peer(const Scenario& scenario, const RunOptions& options, LockstepSocket& socket);

}  // namespace ballservo
