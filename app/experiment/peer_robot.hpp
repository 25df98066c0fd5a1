// A robot that somebody else has, simulates or only claims, with its camera: their ports of the loop.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/simulated_perception.hpp"
#include "app/experiment/simulated_robot.hpp"
#include "app/loop/ports.hpp"
#include "app/peer/lockstep_socket.hpp"
#include "app/scenario/scenario.hpp"

namespace ballservo {

/// Moves the peer on whenever a later time is asked for, by the newest command. All of it throws PeerGone.
class PeerRobot final : public WatchedRobot, public FrameSource {
 public:
  /// Asks the peer for its beginning. Both must outlive the robot.
  PeerRobot(LockstepSocket& socket, const Scenario& scenario, bool pictures);
  ~PeerRobot() override { leave("the program failed"); }

  RobotState read(double now_s) override;
  void command(const Twist2& twist, double) override { command_ = twist; }
  void pan(double speed_radps, double) override { pan_radps_ = speed_radps; }
  bool has_sonars() const override { return has_sonars_; }
  void listen(const std::function<void(const SonarReading&)>& hear) override;

  std::optional<RobotTruth> when_read() const override { return when_read_; }
  const std::vector<SonarFiring>& firings() const override { return firings_; }

  std::optional<CameraFrame> take(Clock& clock, double until_s) override;
  /// What the peer said of the ball in the frame last taken.
  const BallMeasurement& ball() const { return ball_; }

  /// Tells the peer to rest, and why; once.
  void leave(const std::string& why) noexcept;

 private:
  void advance_to(double time_s);

  LockstepSocket& socket_;
  const Scenario& scenario_;
  AnswerBounds bounds_;
  RobotState now_;
  bool has_sonars_ = false, left_ = false;
  Twist2 command_;
  double pan_radps_ = 0;
  std::optional<RobotTruth> truth_, when_read_;
  std::vector<SonarReading> readings_;
  std::deque<LockstepFrame> frames_;
  BallMeasurement ball_;
  std::vector<SonarFiring> firings_;  // none: where the robot was is not known
};

/// Believes what the peer says of the ball.
class PeerPerception final : public SimulatedPerception {
 public:
  PeerPerception(const Scenario& scenario, const PeerRobot& robot) : scenario_(scenario), robot_(robot) {}
  Percept look(const CameraFrame& frame) override;

 private:
  const Scenario& scenario_;
  const PeerRobot& robot_;
};

}  // namespace ballservo
