// What is true while a loop runs, beside what it measures and says: the record of the run, and when it is
// over.
#pragma once

#include <string>

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_record.hpp"
#include "app/experiment/simulated_camera.hpp"
#include "app/experiment/simulated_robot.hpp"
#include "app/loop/loop_observer.hpp"
#include "app/scenario/scenario.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo {

class RunRecorder final : public LoopObserver {
 public:
  /// All three must outlive it. `camera` knows the truth of its frames; null: nobody does. `touched`: the
  /// ball may be moved by somebody.
  RunRecorder(const Scenario& scenario, const WatchedRobot& robot, const SimulatedCamera* camera,
              bool touched);

  void frame(const FrameEvent& event) override;
  void step(const StepEvent& event) override;
  void guard_looked(double time_s) override;
  void guard_rested(double) override { ++wall_.guard_rests; }

  bool over() const { return judge_.over(); }
  /// Its frames are the camera's thread's, its steps the control thread's.
  const RunRecord& record() const { return run_; }

  /// Of the record so far; see RunOptions::remembered_steps.
  void forget(std::size_t most);

  /// The record with its summary, `interrupted` where it is not over, which leaves this empty;
  /// `timing.realtime` only for a run on the wall clock.
  RunRecord finish(bool realtime);

 private:
  void observe(const RobotTruth& robot, StepRecord& record) const;
  std::string collided_with(const ContactReport& contacts, const Twist2& twist) const;

  const Scenario& scenario_;
  const WatchedRobot& robot_;
  const SimulatedCamera* camera_;
  OutcomeJudge judge_;
  RunRecord run_;
  RealtimeTiming wall_;  // each member is one thread's own
  std::string touched_;  // what the footprint touched first
  double guard_looked_s_ = 0;
};

}  // namespace ballservo
