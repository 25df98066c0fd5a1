#include "app/loop/threaded_loop.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>

#include "app/loop/guarded_robot.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/base/numbers.hpp"

namespace ballservo {

namespace {

constexpr double guard_slack_s = 0.02;  // for the guard's own period, and a thread that wakes late

/// A controller that is silent for so long is stopped by the guard.
double silence_s(double rate_hz) { return std::max(2.0 / rate_hz, 0.04); }

GuardOptions guard_options(const LoopPorts& ports) {
  const ControllerOptions& controller = ports.controller.options();
  GuardOptions options;
  options.stale_step_s = silence_s(controller.rate_hz);
  options.sonars = ports.controller.avoidance() != nullptr;
  return options;
}

/// Threads that work until the run is over, and have ended when this has.
class Crew {
 public:
  explicit Crew(const ThreadOptions& options) : options_(options) {}
  ~Crew() { end(); }

  void start(const char* name, std::function<void()> work) {
    const auto guarded = [this, work = std::move(work)] {
      try {
        while (!over_) work();
      } catch (...) {
        const std::lock_guard<std::mutex> lock(failure_mutex_);
        if (!failure_) failure_ = std::current_exception();
      }
      over_ = true;
    };
    try {
      threads_.push_back(options_.start ? options_.start(guarded) : std::thread(guarded));
    } catch (const std::system_error& error) {
      throw Refusal(std::string("no thread for the ") + name + " could be started (" +
                    error.code().message() +
                    "); raise the limits of processes and memory (ulimit -u, ulimit -v)");
    }
  }
  /// Whether one of them has failed.
  bool over() const { return over_; }

  void end() {
    over_ = true;
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }
  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  const ThreadOptions& options_;
  std::atomic<bool> over_{false};
  std::mutex failure_mutex_;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace

ControllerOptions for_threads(ControllerOptions options) {
  options.command_s = silence_s(options.rate_hz) + guard_slack_s;
  return options;
}

void run_threaded_loop(const LoopPorts& ports, Clock& clock, const GoOn& go_on,
                       const ThreadOptions& options) {
  const ControllerOptions& controller = ports.controller.options();
  if (ports.controller.avoidance() != nullptr && controller.command_s < for_threads(controller).command_s) {
    throw InputError("command_s", number_text(controller.command_s),
                     "the controller's options for_threads (s)");
  }
  GuardedRobot robot(ports, clock, guard_options(ports));
  const LoopPorts guarded{ports.camera, ports.perception, robot, ports.controller, ports.observers};
  Loop loop(guarded, clock);
  constexpr double frame_wait_s = 0.1;  // after which the camera's thread looks whether the run is over
  Crew crew(options);
  {
    const RestAtEnd rest(robot, clock);
    crew.start("camera", [&] {
      const double until_s = clock.now_s() + frame_wait_s;
      if (!loop.see(until_s)) clock.sleep_until(until_s);
    });
    crew.start("guard", [&] {
      clock.sleep_until(clock.now_s() + options.guard_period_s);
      robot.guard_now();
      for (LoopObserver* each : ports.observers) each->guard_looked(clock.now_s());
    });
    const auto until_step = [&](double step_s) {
      clock.sleep_until(step_s);
      return !crew.over();
    };
    for (auto time_s = loop.step(until_step); time_s && go_on(*time_s);) time_s = loop.step(until_step);
  }
  crew.end();
  crew.rethrow();
}

}  // namespace ballservo
