// One closed-loop run on the wall clock: camera, control and guard in threads of their own.
#pragma once

#include <functional>
#include <thread>

#include "app/experiment/guarded_drive.hpp"
#include "app/experiment/runner.hpp"

namespace ballservo {

struct RealtimeOptions {
  double guard_period_s = 0.005;
  /// Whether the camera gives frames at that time; a test may take its plug out. Empty: always.
  std::function<bool(double time_s)> camera_lives;
  /// Starts a thread, or throws std::system_error; a test may let it fail. Empty: std::thread.
  std::function<std::thread(std::function<void()> work)> start_thread;
};

struct RealtimeRun {
  RunRecord record;                    ///< `timing.realtime` is filled in
  std::vector<DriveCommand> commands;  ///< all that the drive was told
  std::vector<double> arrivals_s;      ///< of the frames that the controller heard of
};

/// Runs to the end: the judge's word, or `options.go_on`, which is called from the control thread. Robot and
/// world are simulated at the wall clock's time: the camera's thread renders (where there are pictures),
/// looks and hands over what it saw when the camera's latency has passed, or later where it took longer; the
/// control thread steps at its rate; the guard's thread asks the same `guard` as in simulated time, with now
/// and the stamps that came with the last command, and tells the drive to rest where it says so. Not the same
/// twice. Throws InputError as run_closed_loop does, and for `on_picture`, which is not to be had here;
/// Refusal where a thread cannot be started: those that run have then ended.
RealtimeRun run_realtime(const Scenario& scenario, const RunOptions& options,
                         const RealtimeOptions& realtime = {});

}  // namespace ballservo
