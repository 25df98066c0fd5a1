#include "app/experiment/realtime_runner.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <system_error>
#include <vector>

#include "app/experiment/collision_cause.hpp"
#include "app/experiment/control_loop.hpp"
#include "app/experiment/mailbox.hpp"
#include "app/experiment/picture_keeper.hpp"
#include "app/io/ball_rows.hpp"
#include "calibration/base/fault.hpp"

namespace ballservo {

namespace {

/// Seconds. A controller that is silent for so long is stopped by the guard; the shield counts on a little
/// more.
double silence_s(const Scenario& scenario) { return std::max(2.0 / scenario.control_rate_hz, 0.04); }

ControllerOptions realtime_controller(const Scenario& scenario) {
  ControllerOptions options = controller_options(scenario);
  options.command_s = silence_s(scenario) + 0.02;
  return options;
}

GuardOptions realtime_guard(const Scenario& scenario) {
  GuardOptions options;
  options.stale_step_s = silence_s(scenario);
  options.sonars = scenario.robot.sonar && scenario.avoidance.type != AvoidanceOptions::Type::none;
  return options;
}

/// Threads that have ended when it has: also where one of them could not be started.
class Crew {
 public:
  Crew(std::atomic<bool>& over, const RealtimeOptions& options) : over_(over), options_(options) {
    threads_.reserve(3);
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;
  ~Crew() {
    over_ = true;
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }
  template <typename Work>
  void start(const char* name, const Work& work) {
    try {
      threads_.push_back(options_.start_thread ? options_.start_thread(work) : std::thread(work));
    } catch (const std::system_error& error) {
      throw Refusal(std::string("--realtime: no thread for the ") + name + " could be started (" +
                    error.code().message() +
                    "); raise the limits of processes and memory (ulimit -u, ulimit -v), or leave "
                    "--realtime out");
    }
  }
  void wait_for_last() { threads_.back().join(); }

 private:
  std::atomic<bool>& over_;
  const RealtimeOptions& options_;
  std::vector<std::thread> threads_;
};

/// Everything that the threads of a run share, and what each of them does until it is over.
class Realtime {
 public:
  Realtime(const Scenario& scenario, const RunOptions& options, const RealtimeOptions& realtime)
      : scenario_(scenario),
        options_(options),
        realtime_(realtime),
        camera_(scenario, options),
        robot_(scenario, options.seed),
        control_(scenario, realtime_controller(scenario), options.rule),
        pictures_(scenario),
        drive_(robot_, clock_, realtime_guard(scenario)),
        mailbox_(16 + static_cast<std::size_t>(scenario.camera.latency_s * scenario.camera.rate_hz)) {}

  RealtimeRun run() {
    clock_ = RunClock();
    {
      Crew crew(over_, realtime_);
      crew.start("camera", [this] { until_over([this] { see(); }); });
      crew.start("guard", [this] { until_over([this] { watch(); }); });
      crew.start("controller", [this] { until_over([this] { steer(); }); });
      crew.wait_for_last();
    }
    if (failure_) std::rethrow_exception(failure_);
    return result();
  }

 private:
  template <typename Work>
  void until_over(const Work& work) {
    try {
      work();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
    over_ = true;
  }

  /// The camera's thread.
  void see() {
    const double slack_s = 0.5 / scenario_.camera.rate_hz;
    while (!over_) {
      timing_.frames_skipped += camera_.skip_to(clock_.now_s() - slack_s);
      clock_.sleep_until(camera_.next_s());
      const RobotView robot = drive_.look();
      auto frame = camera_.expose(robot.time_s, robot.pose, tracks_csv_);
      if (!frame || (realtime_.camera_lives && !realtime_.camera_lives(robot.time_s))) continue;
      pictures_.take(frame->record, state_, frame->picture);
      frame->picture.release();
      frames_.push_back(frame->record);
      const double now_s = clock_.now_s();
      if (now_s > frame->arrives_s) ++timing_.frames_late;
      frame->arrives_s = std::max(frame->arrives_s, now_s);
      timing_.frame_age_ms.push_back((frame->arrives_s - frame->record.time_s) * 1e3);
      mailbox_.put(std::move(*frame));
    }
  }

  /// The control thread.
  void steer() {
    double last_s = -1;
    for (long tick = 0; !over_; ++tick) {
      clock_.sleep_until(static_cast<double>(tick) / scenario_.control_rate_hz);
      if (const auto rested_s = drive_.rested_since_asked()) control_.rested(*rested_s);
      const RobotView robot = drive_.look();
      while (const auto frame =
                 mailbox_.take([&](const SeenFrame& f) { return f.arrives_s <= robot.time_s; })) {
        control_.hear(*frame);
        arrivals_s_.push_back(frame->arrives_s);
      }
      for (const SonarReading& reading : drive_.listen()) control_.hear(reading);
      const Twist2 command = control_.step(robot);
      drive_.command(command, control_.stamps());
      state_ = control_.record().steps.back().control.state;

      if (last_s >= 0) timing_.control_period_ms.push_back((robot.time_s - last_s) * 1e3);
      last_s = robot.time_s;
      if (control_.over()) return;
      if (options_.go_on && !options_.go_on(robot.time_s)) {
        interrupted_ = true;
        return;
      }
      // What could not be done in time is left out.
      const long due = static_cast<long>(std::floor(clock_.now_s() * scenario_.control_rate_hz));
      if (due > tick) {
        timing_.steps_skipped += due - tick - 1;
        tick = due - 1;
      }
    }
  }

  /// The guard's thread.
  void watch() {
    double last_s = clock_.now_s();
    while (!over_) {
      clock_.sleep_until(last_s + realtime_.guard_period_s);
      drive_.guard_now();
      const double now_s = clock_.now_s();
      timing_.guard_period_ms.push_back((now_s - last_s) * 1e3);
      last_s = now_s;
    }
  }

  /// After the threads have ended.
  RealtimeRun result() {
    RealtimeRun result;
    result.record = control_.finish(interrupted_);
    RunRecord& run = result.record;
    run.frames = std::move(frames_);
    run.tracks_csv = std::move(tracks_csv_);
    run.key_frames = pictures_.finish();
    if (!control_.touched().empty()) {
      run.summary.collision_cause =
          collision_cause(scenario_, {control_.touched(), run.steps, robot_.firings()});
    }
    timing_.guard_rests = std::count_if(drive_.commands().begin(), drive_.commands().end(),
                                        [](const DriveCommand& c) { return c.by_guard; });
    run.timing.realtime = std::move(timing_);
    result.commands = drive_.commands();
    result.arrivals_s = std::move(arrivals_s_);
    return result;
  }

  const Scenario& scenario_;
  const RunOptions& options_;
  const RealtimeOptions& realtime_;
  RunClock clock_;

  // The camera's thread.
  RunCamera camera_;
  std::vector<FrameRecord> frames_;
  std::string tracks_csv_ = ball_rows_header();

  RunRobot robot_;  // within drive_ only
  // The control thread.
  ControlLoop control_;
  std::vector<double> arrivals_s_;
  bool interrupted_ = false;

  PictureKeeper pictures_;  // the camera's thread
  RealtimeTiming timing_;   // each member is one thread's own

  // All of them.
  GuardedDrive drive_;
  Mailbox<SeenFrame> mailbox_;
  std::atomic<ControlState> state_{ControlState::search};
  std::atomic<bool> over_{false};
  std::mutex failure_mutex_;
  std::exception_ptr failure_;
};

}  // namespace

RealtimeRun run_realtime(const Scenario& scenario, const RunOptions& options,
                         const RealtimeOptions& realtime) {
  if (options.on_picture) {
    throw InputError("on_picture", "a film on the wall clock", "none: drawing it would hold the camera up");
  }
  return Realtime(scenario, options, realtime).run();
}

}  // namespace ballservo
