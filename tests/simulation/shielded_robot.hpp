// A robot among random obstacles whose commands pass the shield: for tests against exact geometry.
#pragma once

#include <cmath>

#include "calibration/base/random.hpp"
#include "servo/avoidance/avoidance.hpp"
#include "servo/simulation/robot/odometry.hpp"
#include "servo/simulation/robot/sonar_ring.hpp"
#include "servo/simulation/robot/unicycle_robot.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo::test {

inline constexpr OdometryBound stated_bound{0.01, 0.01, 0.005};

/// A room with boxes and columns, none within `clear_m` of the origin.
inline World random_world(RandomEngine& engine, double clear_m) {
  World world;
  world.room = {-2.5, 2.5, -2.5, 2.5, 2.5, {}, {}, {}};
  const int count = static_cast<int>(uniform_index(engine, 9));
  while (static_cast<int>(world.obstacles.size()) < count) {
    Obstacle obstacle;
    obstacle.name = "thing";
    obstacle.center_m = {uniform(engine, -2.3, 2.3), uniform(engine, -2.3, 2.3), 0.25};
    obstacle.yaw_rad = uniform(engine, 0, 3);
    double reach;
    if (uniform_index(engine, 2) == 0) {
      const BoxShape box{{uniform(engine, 0.02, 0.7), uniform(engine, 0.02, 0.7), 0.5}};
      reach = box.size_m.head<2>().norm() / 2;
      obstacle.shape = box;
    } else {
      const CylinderShape cylinder{uniform(engine, 0.01, 0.25), 0.5};
      reach = cylinder.radius_m;
      obstacle.shape = cylinder;
    }
    if (obstacle.center_m.head<2>().norm() > clear_m + reach) world.obstacles.push_back(obstacle);
  }
  return world;
}

struct ShieldedOptions {
  double excess = 1;  ///< of odometry's error over its bound
  double actuation_delay_s = 0.05;
  SonarOptions sonar;
  std::vector<SonarFault> faults;
  AvoidanceOptions avoidance;
};

/// Drive, odometry, sonars, memory and shield, stepped together at 50 Hz.
class ShieldedRobot {
 public:
  ShieldedRobot(const World& world, const ShieldedOptions& options, std::uint64_t seed)
      : world_(world),
        options_(options),
        drive_({}, limits, options.actuation_delay_s),
        odometry_({stated_bound, options.excess}, {}, seed),
        ring_(world, options.sonar, options.faults, seed),
        avoidance_(with_bound(options.avoidance), limits, 0.02),
        poses_(300),
        predictor_(limits, options.actuation_delay_s, 300) {}

  /// One control step: the verdict on `command`, which is then carried out.
  ShieldVerdict step(const Twist2& command) {
    const double time_s = 0.02 * static_cast<double>(steps_++);
    while (ring_.next_s() <= time_s) {
      advance(ring_.next_s());
      ring_.fire(drive_.pose());
    }
    advance(time_s);
    poses_.add(time_s, odometry_.pose());
    ring_.deliver(time_s, [this](const SonarReading& reading) { avoidance_.hear(reading); });
    avoidance_.see_frame(time_s);
    avoidance_.update(time_s, odometry_.pose(), poses_);
    const RobotMotion acts =
        predictor_.predict(time_s, {odometry_.pose(), odometry_.measure(drive_.twist())});
    const ShieldVerdict verdict = avoidance_.check(time_s, command, acts);
    predictor_.add_command(time_s, verdict.command);
    drive_.command(verdict.command);
    return verdict;
  }

  /// Whether the true robot, if it is told to stand still from the next step on, comes to rest without
  /// touching anything; and whether it does now.
  bool brakes_clear() const {
    UnicycleRobot copy = drive_;
    const double now_s = drive_.time_s();
    copy.advance_to(now_s + 0.02);
    copy.command({});
    for (double time_s = now_s + 0.02;; time_s += 0.04) {
      copy.advance_to(time_s);
      if (find_contacts(world_, pioneer_3dx_footprint, copy.pose(), time_s).collision()) return false;
      if (time_s > now_s + 0.02 + options_.actuation_delay_s && copy.twist().v_mps == 0 &&
          copy.twist().w_radps == 0) {
        return true;
      }
    }
  }

  ContactReport contacts() const {
    return find_contacts(world_, pioneer_3dx_footprint, drive_.pose(), drive_.time_s());
  }
  const Pose2& pose() const { return drive_.pose(); }
  const Twist2& twist() const { return drive_.twist(); }
  const Avoidance& avoidance() const { return avoidance_; }
  double time_s() const { return drive_.time_s(); }

  static constexpr UnicycleLimits limits{};

 private:
  static AvoidanceOptions with_bound(AvoidanceOptions options) {
    options.grid.odometry = stated_bound;
    return options;
  }
  void advance(double time_s) {
    drive_.advance_to(time_s);
    odometry_.move(drive_.pose());
  }

  const World& world_;
  ShieldedOptions options_;
  UnicycleRobot drive_;
  Odometry odometry_;
  SonarRing ring_;
  Avoidance avoidance_;
  PoseHistory poses_;
  MotionPredictor predictor_;
  long steps_ = 0;
};

/// Commands of somebody who wants to go fast and looks nowhere: changes its mind now and then, follows what
/// the drive can follow.
class RecklessDriver {
 public:
  explicit RecklessDriver(RandomEngine& engine) : engine_(engine) {}

  Twist2 next(const Twist2& last) {
    if (left_-- <= 0) {
      left_ = 10 + static_cast<int>(uniform_index(engine_, 120));
      wish_ = {uniform(engine_, -0.4, 1.2),
               uniform_index(engine_, 3) == 0 ? 0.0 : uniform(engine_, -1.5, 1.5)};
    }
    return limit_acceleration(last, wish_, ShieldedRobot::limits, 0.02);
  }

 private:
  RandomEngine& engine_;
  int left_ = 0;
  Twist2 wish_;
};

}  // namespace ballservo::test
