// A closed-loop run of a scenario: the loop of app/loop around a simulated camera and a simulated robot, or a
// peer's; and teaching by showing: the robot stands at the goal, looks, and remembers what it saw.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/experiment/outcome_judge.hpp"
#include "app/experiment/run_record.hpp"
#include "app/experiment/simulated_perception.hpp"
#include "app/experiment/touches.hpp"
#include "app/loop/loop_observer.hpp"
#include "app/peer/lockstep_socket.hpp"
#include "app/scenario/scenario.hpp"
#include "app/scenario/taught_target.hpp"
#include "calibration/color/color_table.hpp"
#include "servo/control/controller.hpp"
#include "servo/features/builtin_laws.hpp"
#include "servo/simulation/robot/sonar_ring.hpp"

namespace ballservo {

/// What is to be said of a gain above max_stable_gain_per_s for the scenario's rates and delays, with the
/// limit; empty for one below.
std::string gain_warning(const Scenario& scenario);

/// A run between two control steps, for somebody who looks on.
struct RunView {
  const Scenario& scenario;  ///< as it has been touched
  const RunRecord& record;
  const std::vector<SonarFiring>& firings;
  const Controller& controller;
};

struct RunOptions {
  PerceptionLevel perception = PerceptionLevel::image;
  std::shared_ptr<const ColorTable> colors;  ///< the scenario's, for level image; may be empty at the others
  LawCatalog laws = builtin_laws();          ///< among which the scenario's law is
  std::shared_ptr<RobotBody> body;           ///< instead of the scenario's drive; may be empty
  TakePicture take_picture;                  ///< instead of rendering; may be empty
  LockstepSocket* controller = nullptr;      ///< where it decides instead of the scenario's; may be null
  /// Receives each camera frame's picture (with what was measured drawn in), the record and the sonars'
  /// firings so far, for videos; frames are rendered for it at any level of perception. May be empty.
  std::function<void(const cv::Mat& picture, const RunRecord& so_far,
                     const std::vector<SonarFiring>& firings)>
      on_picture;
  /// Says after each control step what is done to the run before the next. Empty: nothing, ever; else the run
  /// goes on when the ball is reached, as with one that moves.
  std::function<std::vector<Touch>(const RunView& now)> touch;
  /// Above 0: the record holds the last steps alone, so many or up to twice as many, and as much of all else:
  /// for a run that goes on and on. What the summary says is of them.
  std::size_t remembered_steps = 0;
  /// Called at each control step with the run's time; the run stops as `interrupted` where it says false.
  std::function<bool(double time_s)> go_on;
};

/// The scenario's controller: its law's goal, limits and delays.
ControllerOptions controller_options(const Scenario& scenario);

/// Does again what was done.
std::function<std::vector<Touch>(const RunView& now)> replay(Touches touches);

/// Runs in simulated time to the end: the judge's word, or `go_on`. A reached run ends `hold_s` of the
/// ReachedRule after it settled, plus a tail of `tail_s`. The record is the same for the same scenario,
/// `timing` apart, at any number of threads. Throws InputError where the options do not fit the scenario
/// (level image without colours, or without the target's class among them), and PeerGone where a controller
/// elsewhere never came; one that goes later ends the run as a fault.
RunRecord run_closed_loop(const Scenario& scenario, const RunOptions& options);

/// The same, a control step at a time.
class SteppedRun {
 public:
  /// Both must outlive it.
  SteppedRun(const Scenario& scenario, const RunOptions& options);
  ~SteppedRun();
  /// Does the next step, the frames that are due before it included; false: the run is over. What it throws
  /// ends the run, too. Whatever ends it, the robot is told to rest.
  bool step();
  bool over() const;
  const RunRecord& so_far() const;  ///< steps and frames
  /// The whole record, `interrupted` where the run is not over; ended by `gone`, where a peer is.
  RunRecord finish(const PeerGone* gone = nullptr);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// The same on the wall clock, by run_threaded_loop: the camera's thread renders (where there are pictures)
/// and looks, and what it saw arrives when the camera's latency has passed, or later where it took longer.
/// Not the same twice; `timing.realtime` is filled in. Throws InputError for `on_picture` too, which is not
/// to be had here, and Refusal where a thread cannot be started.
RunRecord run_realtime(const Scenario& scenario, const RunOptions& options);

/// The scenario's controller and perception drive the robot, camera and room of a peer to the end: the
/// judge's word, the peer's, or `options.go_on`. What is true is known as far as the peer tells it. Throws as
/// run_closed_loop does, for a robot that never came.
RunRecord drive_peer(const Scenario& scenario, const RunOptions& options, LockstepSocket& socket);

struct TeachOptions {
  PerceptionLevel perception = PerceptionLevel::image;
  std::shared_ptr<const ColorTable> colors;  ///< for level image
  int frames = 60;                           ///< looked at; the tracker takes the first to confirm the ball
  std::function<void(int done)> progress;    ///< called before each frame; what it throws ends the teaching
};

/// Puts the robot at the scenario's target distance from where the ball is at time 0, facing it, on the line
/// from its start, and looks; a ball that moves stands. Throws Refusal where something is in the way there,
/// or the ball is confirmed in less than half of the frames.
TaughtTarget teach_target(const Scenario& scenario, const TeachOptions& options);

}  // namespace ballservo
