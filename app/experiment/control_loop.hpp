// The control steps of a run: what the controller is told and says, what is true meanwhile, and when it is
// over. The clock is the caller's.
#pragma once

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_camera.hpp"
#include "app/experiment/run_robot.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo {

class ControlLoop {
 public:
  /// `scenario` must outlive it.
  ControlLoop(const Scenario& scenario, const ControllerOptions& controller, const ReachedRule& rule);

  /// A frame has arrived.
  void hear(const SeenFrame& frame);
  /// A sonar's answer has arrived.
  void hear(const SonarReading& reading) { controller_.hear(reading); }
  /// Somebody else told the drive at that time to rest.
  void rested(double time_s) { controller_.rested(time_s); }

  /// One control step, appended to the record; the command for the drive.
  Twist2 step(const RobotView& robot);

  bool over() const { return judge_.over(); }
  SensorStamps stamps() const { return controller_.stamps(); }
  const RunRecord& record() const { return run_; }
  /// What the footprint touched first; empty: nothing.
  const std::string& touched() const { return touched_; }

  /// The record with its summary (all but `collision_cause`), which leaves this empty.
  RunRecord finish(bool interrupted);

 private:
  StepRecord observe(const RobotView& robot) const;
  std::string collided_with(const ContactReport& contacts, const Twist2& twist) const;

  const Scenario& scenario_;
  Controller controller_;
  OutcomeJudge judge_;
  RunRecord run_;
  double perception_ms_ = 0;
  bool heard_ = false;
  std::string touched_;
};

}  // namespace ballservo
