// The same loop on the wall clock with threads: a slow perception holds up neither controller nor guard.
#pragma once

#include <thread>

#include "app/loop/loop.hpp"

namespace ballservo {

struct ThreadOptions {
  double guard_period_s = 0.005;  ///< the guard looks so often
  /// Starts a thread, or throws std::system_error. Empty: std::thread.
  std::function<std::thread(std::function<void()> work)> start{};
};

/// The options of a controller for run_threaded_loop: its shield counts on a command to drive until the guard
/// notices that the next does not come.
ControllerOptions for_threads(ControllerOptions options);

/// Camera and perception run in one thread, the guard in another; controller, robot and `go_on` in the
/// caller's. The guard (servo/avoidance/SAFETY.md) tells the robot to rest where frames, sonars or the
/// controller are silent; each command passes it, too. Ends as run_loop does; first the robot rests, then the
/// threads end: a camera that hangs cannot keep it driving. Throws as run_loop does, InputError for a
/// controller without `for_threads`, and Refusal where a thread cannot be started: those that run have then
/// ended.
void run_threaded_loop(const LoopPorts& ports, Clock& clock, const GoOn& go_on,
                       const ThreadOptions& options = {});

}  // namespace ballservo
