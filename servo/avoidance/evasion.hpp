// Which command keeps the robot out of the way of what moves.
#pragma once

#include <optional>

#include "servo/avoidance/braking_shield.hpp"
#include "servo/avoidance/mover_tracker.hpp"

namespace ballservo {

/// Plans a few seconds ahead among things that go straight on. For steering only: every command still has to
/// pass the shield. Allocates nothing.
class Evasion {
 public:
  Evasion(const MovingThingOptions& moving, const ShieldOptions& shield) : moving_(moving), shield_(shield) {}

  /// The command by which more room is left than by any other that the shield lets pass. Nothing where
  /// driving on as wanted, for however short a while, leaves room enough.
  std::optional<Twist2> command(const Twist2& wanted, const RobotMotion& when_it_acts,
                                const MoverTracker::Movers& movers, const OccupancyGrid& grid,
                                const MovingThings& things) const;

 private:
  double worth_m(const Twist2& command, double held_s, RobotMotion robot, const MoverTracker::Movers& movers,
                 std::size_t guess) const;
  double mean_worth_m(const Twist2& command, double held_s, const RobotMotion& when_it_acts,
                      const MoverTracker::Movers& movers, double least_m) const;

  MovingThingOptions moving_;
  ShieldOptions shield_;
};

}  // namespace ballservo
