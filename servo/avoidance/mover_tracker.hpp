// What moves around the robot, and where to, as far as its sonars can tell.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "calibration/base/random.hpp"
#include "servo/avoidance/moving_things.hpp"
#include "servo/avoidance/sonar.hpp"

namespace ballservo {

/// Where the middle of a disc is, and how it moves, in the odometry's frame.
struct MovingDisc {
  Eigen::Vector2d p_O{0, 0}, v_O{0, 0};  ///< m, m/s
};

/// A thing that moves: guesses of it, each as likely as the others.
struct Mover {
  static constexpr std::size_t guesses = 8;
  std::array<MovingDisc, guesses> discs;
  double speed_sigma_mps = 0;  ///< how far the guesses' velocities lie apart, rms
};

/// Follows what moves. A sonar tells a range well and a direction hardly, and its silence tells as much as
/// its echo, so each thing is a cloud of guesses that every firing makes likelier or less likely: the
/// particle filter of the probability hypothesis density (Vo, Singh and Doucet, "Sequential Monte Carlo
/// methods for multi-target filtering with random finite sets", IEEE Transactions on Aerospace and Electronic
/// Systems 41, 2005). An echo that no cloud explains starts one. For steering only: safety rests on
/// MovingThings. Deterministic; allocates nothing.
class MoverTracker {
 public:
  static constexpr std::size_t max_movers = 12;

  MoverTracker(const MovingThingOptions& moving, const SonarBeam& beam);

  /// It is that time now; times must not run backwards.
  void move(double time_s);
  /// A firing, with the odometry's pose at that moment.
  void look(const SonarReading& reading, const Pose2& pose_then);

  /// What surely moves, now; the first `count` are valid.
  struct Movers {
    std::array<Mover, max_movers> movers;
    std::size_t count = 0;
  };
  Movers movers() const;

  /// The range of the echo of a thing whose middle is there in a transducer's frame (m); infinite where the
  /// beam misses it.
  double heard_from_m(const Eigen::Vector2d& p_T) const;

 private:
  static constexpr std::size_t cloud_size = 192;
  struct Cloud {
    std::array<MovingDisc, cloud_size> discs;
    std::array<double, cloud_size> weights;
    double weight = 0;  // their sum: how surely there is a thing; 0: a place for another
  };

  MovingDisc guess(const SonarReading& reading, const Pose2& transducer);
  void start(const SonarReading& reading, const Pose2& transducer, double weight);
  void resample(Cloud& cloud);

  MovingThingOptions moving_;
  SonarBeam beam_;
  Eigen::Vector2d beam_side_;  // along one side of the cone, the axis being x
  RandomEngine random_ = random_stream(0, "mover_tracker");
  std::array<Cloud, max_movers> clouds_;
  bool started_ = false;
  double time_s_ = 0;
};

}  // namespace ballservo
