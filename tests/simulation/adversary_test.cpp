// An adversary against the theorem of servo/avoidance/SAFETY.md: whatever the assumptions leave open is
// chosen to hurt.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <ostream>

#include "calibration/base/random.hpp"
#include "servo/avoidance/avoidance.hpp"
#include "servo/simulation/robot/sonar_ring.hpp"
#include "servo/simulation/world/collision.hpp"

namespace ballservo {
namespace {

/// What goes beyond its bound; all held: `none`.
enum class Broken { none, echo, range, odometry, drive, start };

double either(RandomEngine& engine, double a, double b) { return uniform_index(engine, 2) == 0 ? a : b; }

/// A robot, what is known of it, and where it is.
struct Duel {
  AvoidanceOptions avoidance;
  UnicycleLimits limits;
  SonarOptions sonar;
  double delay_s, period_s;
  World world;
};

/// A room, and in it columns, boxes and pairs of poles between which the robot does not fit; or a long way
/// that ends at such a pair.
World draw_world(RandomEngine& engine, double clear_m) {
  World world;
  const bool runway = uniform_index(engine, 3) == 0;
  const double a = runway ? 12.0 : uniform(engine, 1.2, 9.0), b = uniform(engine, 1.2, 4.0);
  world.room = {-uniform(engine, 1.2, 3.0), a, -b, uniform(engine, 1.2, 4.0), 2.5, {}, {}, {}};
  const auto put = [&](const Obstacle& obstacle) {
    if (obstacle.center_m.head<2>().norm() > clear_m + obstacle.outline_radius_m())
      world.obstacles.push_back(obstacle);
  };
  const auto put_poles = [&](Obstacle pole, double gap_m) {
    pole.shape = CylinderShape{0.02, 0.5};
    for (const double side_m : {-0.5 * gap_m, gap_m}) {
      pole.center_m.y() += side_m;
      put(pole);
    }
  };
  const std::uint32_t count = runway ? 0 : uniform_index(engine, 12);
  Obstacle thing;
  thing.name = "thing";
  thing.center_m = {uniform(engine, 3, 9), 0, 0.25};
  if (runway) put_poles(thing, uniform(engine, 0.2, 0.4));
  for (std::uint32_t k = 0; k < count; ++k) {
    thing.center_m = {uniform(engine, world.room.x_min_m, a), uniform(engine, -b, b), 0.25};
    thing.yaw_rad = uniform(engine, 0, 3);
    const std::uint32_t kind = uniform_index(engine, 3);
    if (kind == 0) thing.shape = BoxShape{{uniform(engine, 0.02, 2.0), uniform(engine, 0.02, 0.4), 0.5}};
    if (kind == 1) thing.shape = CylinderShape{uniform(engine, 0.01, 0.25), 0.5};
    kind == 2 ? put_poles(thing, uniform(engine, 0.2, 0.5)) : put(thing);
  }
  return world;
}

Duel draw_duel(RandomEngine& engine, Broken broken) {
  Duel duel;
  const double hard =
      either(engine, 1, uniform01(engine));  // of a robot that is told little of its own errors, or much
  duel.limits = {uniform(engine, 0.3, 2.0), uniform(engine, 0.5, 5.0),
                 either(engine, 0.3, uniform(engine, 0.3, 2.0)), uniform(engine, 0.7, 4.0)};
  duel.delay_s = either(engine, uniform(engine, 0, 0.1), uniform(engine, 0, 0.5));
  duel.period_s = 1.0 / either(engine, 50, uniform(engine, 8, 50));
  duel.sonar.period_s = either(engine, 0.02, 0.04);
  duel.sonar.beam.half_angle_rad = uniform(engine, 0.2, 0.5);
  duel.sonar.beam.min_range_m = uniform(engine, 0.02, 0.4);
  OccupancyGridOptions& grid = duel.avoidance.grid;
  duel.avoidance.type = AvoidanceOptions::Type::shield;
  duel.avoidance.creep = false;
  grid.beam = duel.sonar.beam;
  grid.odometry = {either(engine, 0, 0.2 * hard * hard), either(engine, 0, 0.1 * hard * hard),
                   either(engine, 0, 0.05 * hard * hard)};
  grid.range_error_m = uniform(engine, 0.01, 0.05);
  grid.look_range_m = uniform(engine, 1.5, 3.0);
  grid.drift_allowed_m = uniform(engine, 0.02, 0.04 + 0.26 * hard);
  grid.footprint = {uniform(engine, 0.18, 0.30), uniform(engine, 0.27, 0.40), uniform(engine, 0.14, 0.30)};
  grid.start_clear_m = grid.footprint.reach_m() + grid.drift_allowed_m + uniform(engine, 0.1, 0.3);
  duel.world =
      draw_world(engine, broken == Broken::start ? grid.footprint.reach_m() + 0.01 : grid.start_clear_m);
  return duel;
}

/// What the drive does, the sonars say and the odometry measures, all as bad as it may be.
class Adversary {
 public:
  Adversary(const Duel& duel, Broken broken, RandomEngine& engine)
      : duel_(duel), broken_(broken), engine_(engine), ring_(duel.world, duel.sonar, {}, 0) {
    const double corner_m = duel.avoidance.grid.footprint.reach_m();
    const UnicycleLimits& l = duel.limits;
    const double ahead_s = duel.delay_s + duel.period_s;
    const double way_m = l.v_max_mps * ahead_s + 0.5 * l.v_max_mps * l.v_max_mps / l.a_max_mps2;
    const double turn_rad =
        l.w_max_radps * ahead_s + 0.5 * l.w_max_radps * l.w_max_radps / l.alpha_max_radps2;
    const double sign = either(engine, -1, 1);
    if (uniform_index(engine, 3) == 0) {
      veer_radpm_ = sign * drive_model_m / (way_m * (way_m + corner_m));
    } else {
      scale_ = 1.0 + sign * drive_model_m / (way_m + corner_m * turn_rad);
    }
    policy_ = uniform_index(engine, 3);
    for (double& each : signs_) each = either(engine, -1, 1);
  }

  void command(const Twist2& twist) { pending_.push_back({time_s_ + duel_.delay_s, twist}); }

  /// Moves on; whether nothing is touched on the way.
  bool advance_to(double until_s, const std::function<void(const SonarReading&)>& fired) {
    double unchecked_m = 1;
    choose();
    while (time_s_ < until_s) {
      for (; !pending_.empty() && pending_.front().first <= time_s_; pending_.pop_front())
        followed_ = pending_.front().second;
      const double next_s =
          std::min({time_s_ + 1e-3, until_s, pending_.empty() ? until_s : pending_.front().first});
      const double dt_s = next_s - time_s_;
      move(dt_s);
      const double moved_m = dt_s * (std::abs(twist_.v_mps) + std::abs(twist_.w_radps) * 0.5);
      if ((unchecked_m += moved_m) > 0.004 || next_s == until_s) {
        unchecked_m = 0;
        clearance_m_ = contacts().clearance_m;
        if (clearance_m_ <= 0) return false;
      }
      time_s_ = next_s;
      for (; 0.5 * duel_.sonar.period_s * firing_ <= time_s_; ++firing_) fired(fire());
    }
    return true;
  }

  /// Whether it comes to rest without touching anything if it is told to from now on.
  bool brakes_clear() const {
    const double ahead_s = duel_.delay_s + duel_.period_s;
    const double v = std::abs(twist_.v_mps) + duel_.limits.a_max_mps2 * ahead_s;
    const double w = std::abs(twist_.w_radps) + duel_.limits.alpha_max_radps2 * ahead_s;
    const double way_m = v * ahead_s + 0.5 * v * v / duel_.limits.a_max_mps2;
    const double turn_rad = w * ahead_s + 0.5 * w * w / duel_.limits.alpha_max_radps2;
    if (clearance_m_ > 1.1 * (way_m + turn_rad * duel_.avoidance.grid.footprint.reach_m())) return true;
    Adversary copy(*this);
    const auto deaf = [](const SonarReading&) {};
    if (!copy.advance_to(time_s_ + duel_.period_s, deaf)) return false;
    copy.command({});
    for (int k = 1; k < 2000 && (!copy.pending_.empty() || copy.moves()); ++k) {
      if (!copy.advance_to(copy.time_s_ + 0.02, deaf)) return false;
    }
    return true;
  }

  bool moves() const { return twist_.v_mps != 0 || twist_.w_radps != 0; }
  const Pose2& odometry() const { return odometry_; }
  const Pose2& pose() const { return pose_; }
  double clearance_m() const { return clearance_m_; }
  Twist2 measured() const {
    const OdometryBound& bound = duel_.avoidance.grid.odometry;
    const double sign = policy_ == 0 ? -1 : signs_[0];
    return {twist_.v_mps * (1 + sign * excess() * bound.distance_share),
            twist_.w_radps * (1 + sign * excess() * bound.turn_share)};
  }

 private:
  double excess() const { return broken_ == Broken::odometry ? 4 : 1; }
  ContactReport contacts() const {
    return find_contacts(duel_.world, duel_.avoidance.grid.footprint, pose_, 0);
  }

  /// The signs of odometry's errors: such that what is near seems further off, as they were, or any.
  void choose() {
    if (policy_ == 0) {
      constexpr double h = 0.01;  // which way of moving comes nearer
      const auto clearance_at = [this](const Twist2& by) {
        return find_contacts(duel_.world, duel_.avoidance.grid.footprint, integrate(pose_, by, h), 0)
            .clearance_m;
      };
      signs_[0] = (clearance_at({1, 0}) < clearance_at({-1, 0})) == (twist_.v_mps > 0) ? -1 : 1;
      turn_sign_ = clearance_at({0, 1}) < clearance_at({0, -1}) ? -1 : 1;
    } else if (policy_ == 1 && uniform_index(engine_, 50) == 0) {
      signs_[uniform_index(engine_, 2)] *= -1;
      turn_sign_ = signs_[1];
    }
  }

  void move(double dt_s) {
    UnicycleLimits limits = duel_.limits;
    if (broken_ == Broken::drive && followed_.v_mps == 0 && followed_.w_radps == 0) {
      limits.a_max_mps2 *= 0.6;
      limits.alpha_max_radps2 *= 0.6;
    }
    const RobotMotion after = drive({{}, model_}, followed_, limits, dt_s, 1);
    Twist2 mean = mean_twist(model_, after.twist);
    model_ = after.twist;
    const auto truly = [this](const Twist2& t) {
      return Twist2{scale_ * t.v_mps, scale_ * t.w_radps + veer_radpm_ * t.v_mps};
    };
    mean = truly(mean);
    twist_ = truly(model_);
    pose_ = integrate(pose_, mean, dt_s);
    const OdometryBound& bound = duel_.avoidance.grid.odometry;
    const double turn =
        bound.turn_share * std::abs(mean.w_radps) + bound.turn_per_m_radpm * std::abs(mean.v_mps);
    odometry_ = integrate(odometry_,
                          {mean.v_mps * (1 + excess() * signs_[0] * bound.distance_share),
                           mean.w_radps + excess() * turn_sign_ * turn},
                          dt_s);
  }

  SonarReading fire() {
    const auto turn = static_cast<std::size_t>(firing_);
    SonarReading reading{time_s_, 8 * (turn % 2) + sonar_firing_order[(turn / 2) % 8], 0, false};
    // Where it was when it fired is known to half a centimetre: the rest of the bound is its own.
    const double error_m = duel_.avoidance.grid.range_error_m - 0.005;
    const SonarBeam& beam = duel_.sonar.beam;
    double range_m = ring_.true_range_m(pose_, reading.transducer, time_s_) + error_m;
    if (broken_ == Broken::range) range_m += 0.3;
    if (broken_ == Broken::echo && reading.transducer < 8) range_m = beam.max_range_m;
    reading.range_m = std::clamp(range_m, beam.min_range_m, beam.max_range_m);
    reading.echo = reading.range_m < beam.max_range_m;
    return reading;
  }

  const Duel& duel_;
  Broken broken_;
  RandomEngine engine_;
  SonarRing ring_;
  double scale_ = 1, veer_radpm_ = 0;  // of the drive, within its model's error
  std::uint32_t policy_ = 0;
  std::array<double, 2> signs_{};
  double turn_sign_ = 1;
  double time_s_ = 0, clearance_m_ = 0;
  long firing_ = 0;
  Pose2 pose_, odometry_;
  Twist2 model_, twist_, followed_;
  std::deque<std::pair<double, Twist2>> pending_;
};

/// Wants to go fast: anywhere, or straight on more often than not.
class Driver {
 public:
  Driver(const Duel& duel, RandomEngine& engine)
      : duel_(duel), engine_(engine), greedy_(uniform_index(engine, 2) == 0) {}

  Twist2 next() {
    if (left_-- <= 0) {
      left_ =
          5 + static_cast<int>(uniform_index(engine_, 3 * static_cast<std::uint32_t>(1.0 / duel_.period_s)));
      const UnicycleLimits& l = duel_.limits;
      wish_ = {
          l.v_max_mps * (greedy_ ? either(engine_, 1, uniform(engine_, -1, 1)) : uniform(engine_, -0.5, 1)),
          l.w_max_radps *
              either(engine_, 0, either(engine_, uniform(engine_, -1, 1), uniform(engine_, -0.1, 0.1)))};
    }
    return wish_;
  }

 private:
  const Duel& duel_;
  RandomEngine& engine_;
  bool greedy_;
  int left_ = 0;
  Twist2 wish_;
};

struct Tally {
  long commands = 0, moving = 0, duels = 0, contacts = 0;
  double way_m = 0, nearest_m = 10;
};

std::ostream& operator<<(std::ostream& out, const Tally& tally) {
  return out << tally.commands << " commands in " << tally.duels << " duels, " << tally.moving
             << " in motion, " << tally.way_m << " m, " << tally.contacts << " contacts, nearest "
             << 1e3 * tally.nearest_m << " mm";
}

void fight(std::uint64_t seed, Broken broken, int commands, Tally& tally) {
  RandomEngine engine = random_stream(seed, "adversary");
  const Duel duel = draw_duel(engine, broken);
  Adversary adversary(duel, broken, engine);
  Driver driver(duel, engine);
  Avoidance avoidance(duel.avoidance, duel.limits, duel.delay_s, duel.period_s);
  MotionPredictor predictor(duel.limits, duel.delay_s, 300);
  PoseHistory poses(300);
  ++tally.duels;
  const auto hear = [&](const SonarReading& reading) { avoidance.hear(reading); };
  for (int k = 0; k < commands; ++k) {
    const double now_s = duel.period_s * k;
    if (k > 0 && !adversary.advance_to(now_s, hear)) {
      ++tally.contacts;
      return;
    }
    ++tally.commands;
    tally.moving += adversary.moves();
    const Pose2 odometry = adversary.odometry();
    poses.add(now_s, odometry);
    avoidance.see_frame(now_s);
    avoidance.update(now_s, odometry, poses);
    const Twist2 twist = predictor.twist_at(now_s, adversary.measured(), duel.avoidance.grid.odometry);
    const Twist2 command =
        avoidance.check(now_s, driver.next(), predictor.predict(now_s, {odometry, twist})).command;
    predictor.add_command(now_s, command);
    adversary.command(command);
    if (!adversary.brakes_clear()) {
      ++tally.contacts;
      return;
    }
    if (k > 0) tally.nearest_m = std::min(tally.nearest_m, adversary.clearance_m());
  }
  tally.way_m += std::hypot(adversary.pose().x_m, adversary.pose().y_m);
}

#ifndef BALLSERVO_COMMANDS
#define BALLSERVO_COMMANDS 60000
#endif

TEST(Adversary, FindsNoContact) {
  Tally tally;
  for (std::uint64_t seed = 0; tally.commands < BALLSERVO_COMMANDS; ++seed) {
    fight(seed, Broken::none, 600, tally);
    ASSERT_EQ(tally.contacts, 0) << seed << ": " << tally;
  }
  EXPECT_GT(tally.moving, tally.commands / 4) << tally << ": a robot that stands proves nothing";
  std::cout << tally << "\n";
}

TEST(Adversary, FindsAContactWhereOneAssumptionIsBroken) {
  for (const Broken broken : {Broken::echo, Broken::range, Broken::odometry, Broken::drive, Broken::start}) {
    Tally tally;
    for (std::uint64_t seed = 0; seed < 200 && tally.contacts == 0; ++seed) fight(seed, broken, 600, tally);
    EXPECT_GT(tally.contacts, 0) << static_cast<int>(broken) << ": " << tally;
    std::cout << static_cast<int>(broken) << ": " << tally << "\n";
  }
}

}  // namespace
}  // namespace ballservo
