// The closed loop: camera -> perception -> controller -> robot, each at its own rate.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "app/loop/clock.hpp"
#include "app/loop/loop_observer.hpp"
#include "app/loop/mailbox.hpp"
#include "app/loop/ports.hpp"
#include "servo/control/controller.hpp"

namespace ballservo {

/// What is plugged in; all of it must outlive the run.
struct LoopPorts {
  FrameSource& camera;
  BallPerception& perception;
  Robot& robot;
  Controller& controller;
  std::vector<LoopObserver*> observers{};
};

/// Called after each control step, in the control thread: false ends the run.
using GoOn = std::function<bool(double time_s)>;

/// Runs in the caller's thread until `go_on` says no, at the controller's rate: frames that are due, then the
/// control step. On a SteppedClock the same ports give the same run; on a WallClock a slow perception delays
/// the control steps (run_threaded_loop does not). Whatever ends it, the robot is told to rest. Throws what
/// ports and observers throw, and InputError for a controller with avoidance and a robot without sonars.
void run_loop(const LoopPorts& ports, Clock& clock, const GoOn& go_on);

/// The two halves of the loop, for drivers that call them from one thread or from two.
class Loop {
 public:
  Loop(const LoopPorts& ports, Clock& clock);

  /// The camera's half: takes a frame that is due by then, looks at it, and puts what it shows on its way to
  /// the controller. False: there was none.
  bool see(double until_s);

  /// The controller's half: its next step once `until_step` has waited for the step's time, which is
  /// returned; nothing where that says no.
  std::optional<double> step(const std::function<bool(double step_s)>& until_step);

  /// Both halves: the frames that are due before the next control step, then that. Its time.
  double advance();

 private:
  struct Seen {
    Percept percept;
    double arrived_s = 0, perception_s = 0;
  };
  double control(long skipped);
  double hear(double now_s);

  const LoopPorts& ports_;
  Clock& clock_;
  Mailbox<Seen> on_the_way_;
  long tick_ = -1, steps_ = 0;
  ControlState state_ = ControlState::search;
};

/// Tells the robot to rest when it goes out of scope, whatever happened; swallows what the robot then throws.
class RestAtEnd {
 public:
  RestAtEnd(Robot& robot, const Clock& clock) : robot_(robot), clock_(clock) {}
  RestAtEnd(const RestAtEnd&) = delete;
  RestAtEnd& operator=(const RestAtEnd&) = delete;
  ~RestAtEnd();

 private:
  Robot& robot_;
  const Clock& clock_;
};

}  // namespace ballservo
