// Everything between what a law asks for and what the drive is told: the sonars' memory, the guard, the
// shield.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

#include "servo/avoidance/braking_shield.hpp"
#include "servo/avoidance/evasion.hpp"
#include "servo/avoidance/mover_tracker.hpp"
#include "servo/avoidance/moving_things.hpp"
#include "servo/avoidance/obstacle_map.hpp"
#include "servo/avoidance/occupancy_grid.hpp"
#include "servo/avoidance/sonar.hpp"
#include "servo/avoidance/steering.hpp"
#include "servo/motion/motion_history.hpp"

namespace ballservo {

class OptionVisitor;

struct AvoidanceOptions {
  /// none: the law drives alone. shield: its commands pass the guard and the shield. full: ways around
  /// obstacles are looked for too.
  enum class Type { none, shield, full };
  Type type = Type::none;
  OccupancyGridOptions grid;
  MovingThingOptions moving;    ///< what is reckoned with besides things that rest
  bool creep = true;            ///< see ShieldOptions
  bool floor = true;            ///< what the camera sees standing on the floor is not free
  double half_view_rad = 0.50;  ///< the ball further aside of where the camera looks is out of the picture
};

/// The keys of a scenario's `avoidance` but its type.
void declare(OptionVisitor& v, AvoidanceOptions& avoidance);

inline std::string_view avoidance_type_name(AvoidanceOptions::Type type) {
  constexpr std::string_view names[] = {"none", "shield", "full"};
  return names[static_cast<std::size_t>(type)];
}

class Avoidance {
 public:
  Avoidance(const AvoidanceOptions& options, const UnicycleLimits& limits, double delay_s, double period_s);

  /// An answer of a sonar, as it arrives.
  void hear(const SonarReading& reading) { readings_.put(reading); }
  /// What a frame showed of the floor, as it arrives; with `floor` only.
  void see(const FloorScan& scan) {
    if (options_.floor) scans_.put(scan);
  }
  /// A frame of the camera arrived then, whatever it showed; the camera is turned so far.
  void see_frame(double arrived_s, double pan_rad = 0) {
    frame_s_ = arrived_s;
    pan_rad_ = pan_rad;
  }

  /// A control step begins: the robot is there; `poses` holds where it was.
  void update(double now_s, const Pose2& pose, const PoseHistory& poses);

  /// The guard's and the shield's word on a command that acts from that motion on.
  ShieldVerdict check(double now_s, const Twist2& command, const RobotMotion& when_it_acts);

  /// Whether ways around obstacles are looked for (type full).
  bool steers() const { return steering_.has_value(); }
  /// The way to the ball; only where steers().
  SteeringOutput steer(const SteeringInput& input);
  /// Where to look for the ball next; only where steers().
  Eigen::Vector2d place_to_look_from() { return steering_->place_to_look_from(*map_, grid_, viewed_); }
  /// What a turn on the spot would show; only where steers().
  UnseenFloor unseen_from_here() const { return viewed_.unseen_from(grid_.pose(), *map_); }
  /// The ball was lost there: what was seen before counts no longer, and it is rather near.
  void expect_ball(const Eigen::Vector2d& p_OB) { viewed_.expect(p_OB); }
  void reset_steering() {
    if (steering_) steering_->reset();
  }

  const OccupancyGrid& grid() const { return grid_; }
  const SonarWatch& watch() const { return watch_; }

 private:
  /// What arrives between two steps; more than fits is dropped.
  template <typename Message, std::size_t size>
  struct Inbox {
    std::array<Message, size> messages;
    std::size_t count = 0;

    void put(const Message& message) {
      if (count < size) messages[count++] = message;
    }
  };

  /// What is reckoned with where things move.
  struct Moving {
    MovingThings things;
    MoverTracker tracker;
    Evasion evasion;
    std::optional<Twist2> evasive;  // the plan's command, for some steps
    unsigned steps = 0;

    Moving(const MovingThingOptions& options, const OccupancyGridOptions& grid, const ShieldOptions& shield)
        : things(options, grid), tracker(options, grid.beam), evasion(options, shield) {}
  };

  AvoidanceOptions options_;
  ShieldOptions shield_;
  OccupancyGrid grid_;
  std::optional<Moving> moving_;  // where anything moves
  SonarWatch watch_;
  std::optional<ObstacleMap> map_;  // with steering
  std::optional<Steering> steering_;
  ViewedFloor viewed_;
  ShieldVerdict last_;
  Inbox<SonarReading, 64> readings_;
  Inbox<FloorScan, 4> scans_;
  double frame_s_ = SensorStamps::never, viewed_s_ = SensorStamps::never, way_m_ = 0;
  double pan_rad_ = 0;         // of the camera, now
  std::optional<Pose2> pose_;  // at the step before
};

}  // namespace ballservo
