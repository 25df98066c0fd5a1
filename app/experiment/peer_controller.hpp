// Somebody else's controller in place of ours: what the robot hears and sees goes to it, a step at a time.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/run_record.hpp"
#include "app/experiment/simulated_perception.hpp"
#include "app/loop/loop_observer.hpp"
#include "app/peer/lockstep_socket.hpp"
#include "app/scenario/scenario.hpp"
#include "servo/control/controller.hpp"

namespace ballservo {

/// Observes the frames, which it hands on as they arrive.
class PeerController final : public Controller, public LoopObserver {
 public:
  /// What Controller needs, though neither decides anything. `socket` must outlive it.
  PeerController(const ControllerOptions& options, std::unique_ptr<Law> law, const Scenario& scenario,
                 LockstepSocket& socket);

  void hear(const SonarReading& reading) override { readings_.push_back(reading); }
  void frame(const FrameEvent& event) override;
  /// Answers the peer, and waits for what it asks next. Throws PeerGone.
  ControlOutput step(double time_s, const Pose2& odometry, const Twist2& odometry_twist) override;

  /// Throws PeerGone where the peer has said that it leaves.
  void throw_if_gone() const;
  /// Answers the peer for the last time.
  void leave(const RunSummary& summary);

 private:
  LockstepSocket& socket_;
  nlohmann::json facts_;  // for the first answer
  bool sonars_;
  TrackState last_seen_ = TrackState::none;
  std::optional<LockstepRequest> request_;
  std::vector<SonarReading> readings_;
  std::deque<LockstepFrame> frames_;
};

/// Looks at no picture: the peer does.
class BlindPerception final : public SimulatedPerception {
 public:
  Percept look(const CameraFrame& frame) override {
    Percept percept;
    percept.ball.time_s = frame.time_s;
    return percept;
  }
};

}  // namespace ballservo
