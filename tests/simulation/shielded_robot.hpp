// A robot among random obstacles whose commands pass the shield: for tests against exact geometry.
#pragma once

#include <cmath>
#include <memory>

#include "app/experiment/simulated_robot.hpp"
#include "calibration/base/random.hpp"
#include "servo/avoidance/avoidance.hpp"
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

/// The simulated robot with memory and shield, stepped together at 50 Hz. No loop: it has no camera, no law
/// and no goal.
class ShieldedRobot {
 public:
  ShieldedRobot(const World& world, double actuation_delay_s, std::uint64_t seed,
                const MovingThingOptions& moving = {})
      : world_(world),
        actuation_delay_s_(actuation_delay_s),
        body_(std::make_shared<UnicycleRobot>(Pose2{}, limits, actuation_delay_s)),
        robot_(world, settings(actuation_delay_s), seed, body_),
        avoidance_(avoidance(moving), limits, actuation_delay_s, period_s),
        poses_(300),
        predictor_(limits, actuation_delay_s, 300) {}

  /// One control step: the verdict on `command`, which is then carried out.
  ShieldVerdict step(const Twist2& command) {
    const RobotState now = robot_.read(period_s * static_cast<double>(steps_++));
    poses_.add(now.time_s, now.odometry);
    robot_.listen([this](const SonarReading& reading) { avoidance_.hear(reading); });
    avoidance_.see_frame(now.time_s);
    avoidance_.update(now.time_s, now.odometry, poses_);
    const RobotMotion acts = predictor_.predict(
        now.time_s, {now.odometry, predictor_.twist_at(now.time_s, now.twist, stated_bound)});
    const ShieldVerdict verdict = avoidance_.check(now.time_s, command, acts);
    predictor_.add_command(now.time_s, verdict.command);
    robot_.command(verdict.command, now.time_s);
    return verdict;
  }

  /// Whether the true robot, if it is told to stand still from the next step on, comes to rest without
  /// touching anything; and whether it does now.
  bool brakes_clear() const {
    UnicycleRobot copy = *body_;
    const double next_s = copy.time_s() + period_s;
    copy.advance_to(next_s);
    copy.command({});
    for (double time_s = next_s;; time_s += 0.04) {
      copy.advance_to(time_s);
      if (find_contacts(world_, pioneer_3dx_footprint, copy.pose(), time_s).collision()) return false;
      if (time_s > next_s + actuation_delay_s_ && copy.twist().v_mps == 0 && copy.twist().w_radps == 0) {
        return true;
      }
    }
  }

  const Pose2& pose() const { return robot_.now().pose; }
  const Twist2& twist() const { return robot_.now().twist; }

  static constexpr UnicycleLimits limits{};
  static constexpr double period_s = 0.02;

 private:
  static RobotSettings settings(double actuation_delay_s) {
    RobotSettings settings;
    settings.actuation_delay_s = actuation_delay_s;
    settings.odometry = {stated_bound, 1};
    settings.sonar = SonarOptions{};
    return settings;
  }
  static AvoidanceOptions avoidance(const MovingThingOptions& moving) {
    AvoidanceOptions options;
    options.moving = moving;
    options.grid.odometry = stated_bound;
    return options;
  }

  const World& world_;
  double actuation_delay_s_;
  std::shared_ptr<UnicycleRobot> body_;  // of which a copy shows what would come
  SimulatedRobot robot_;
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
