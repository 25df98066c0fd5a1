// Who is told what happens in the loop: a log, a film, a judge, a live page.
#pragma once

#include <limits>

#include "app/loop/ports.hpp"
#include "servo/control/controller.hpp"

namespace ballservo {

/// A frame that was looked at.
struct FrameEvent {
  const CameraFrame& frame;
  const Percept& percept;
  double arrived_s;     ///< when it was on its way to the controller, or is to be heard of by it
  double perception_s;  ///< processor time of perception
};

/// A control step.
struct StepEvent {
  long step;              ///< counts from 0
  RobotState robot;       ///< when it began
  ControlOutput control;  ///< its command has been given to the robot
  double control_s;       ///< processor time of the controller
  /// Processor time of perception for the newest frame heard of in this step; NaN: no frame came.
  double perception_s = std::numeric_limits<double>::quiet_NaN();
  long skipped = 0;  ///< steps left out before it, since the clock had passed them
};

/// References and pictures are good until the call returns. What an observer throws ends the run.
class LoopObserver {
 public:
  virtual ~LoopObserver() = default;
  /// In the camera's thread.
  virtual void frame(const FrameEvent& event) { (void)event; }
  /// In the control thread, after the command was given.
  virtual void step(const StepEvent& event) { (void)event; }
  /// In the control thread, after `step`: the controller's state is another than at the last step.
  virtual void transition(const StepEvent& event, ControlState from) { (void)event, (void)from; }
  /// In the guard's thread, after each of its looks (run_threaded_loop).
  virtual void guard_looked(double time_s) { (void)time_s; }
  /// The guard has told the robot to rest, at one of its looks or instead of a command: in its thread or the
  /// control thread, never in both at once.
  virtual void guard_rested(double time_s) { (void)time_s; }
};

}  // namespace ballservo
