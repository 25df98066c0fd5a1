// The laws: from where the ball is to how the robot should move.
//
// All laws serve one physical goal: the ball's centre straight ahead of the robot, at a stated distance from
// the axle, in the floor plane. Each derives its own desired features from it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "servo/motion/camera_mount.hpp"
#include "servo/motion/unicycle.hpp"

namespace ballservo {

class OptionVisitor;

/// Where every law stops: ball at (distance_m, 0, ball_height_m) of the robot frame.
struct ServoGoal {
  double distance_m = 0.8;      ///< axle to the ball's centre, in the floor plane
  double ball_height_m = 0.06;  ///< of the ball's centre over the floor
  double ball_radius_m = 0.06;  ///< as perception believes
  CameraMount mount;            ///< as the robot believes
  /// Taught by showing: C/R, the ball's centre in the camera frame at the goal in units of its radius, as it
  /// was seen there. What perception believes of diameter and camera then cancels, as long as it stays the
  /// same.
  std::optional<Eigen::Vector3d> taught_center_over_radius{};

  /// The ball's centre in the camera frame at the goal (m): as taught where it was, else by the distance.
  Eigen::Vector3d desired_p_CB() const;
  /// In the robot frame, where sightings put the ball `scale` times as far from the camera as it is;
  /// (distance_m, 0, ball_height_m) where nothing was taught.
  Eigen::Vector3d desired_p_RB(double scale = 1) const;
};
void declare(OptionVisitor& v, ServoGoal& goal);

struct LawOptions {
  std::string name = "cone";  ///< of a law in the program's LawCatalog
  double gain_per_s = 2.0;    ///< lambda of the exponential decay that the law asks for: de/dt = -lambda e
};
/// `names` are those of the program's laws.
void declare(OptionVisitor& v, LawOptions& law, const std::vector<std::string>& names);

/// What a law asks for, before anybody looks at what the robot can do. Always finite.
struct LawOutput {
  Twist2 twist;
  double error_1 = 0, error_2 = 0;  ///< features less desired features, in the law's own order
};

/// A control law: anything that answers with a twist. One law serves one run, and one thread at a time.
class Law {
 public:
  virtual ~Law() = default;

  /// The twist for a ball at p_CB (m) that moves over ground at v_CB (m/s, in camera axes), in the frame of
  /// the camera looking straight ahead: a law does not see a pan. Nothing where the law has no answer:
  /// features undefined there, the ball abeam of the axle or behind it, or a value that is not finite; the
  /// controller then turns towards the ball. It must not depend on how the floor is turned. It may take
  /// memory from the heap: of a control step, all but this takes none.
  virtual std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) = 0;
};

/// The laws that exist in a program, by name.
/// A value: a program copies the catalog of builtin_laws(), adds laws of its own, and hands it to whatever
/// reads a law's name.
class LawCatalog {
 public:
  /// Makes a law for options and goal that have been checked; throws InputError where the law cannot serve
  /// that goal.
  using Factory = std::function<std::unique_ptr<Law>(const LawOptions&, const ServoGoal&)>;

  /// Adds a law, or replaces the one of that name.
  void add(const std::string& name, Factory factory);

  /// In the order in which they were added.
  std::vector<std::string> names() const;

  /// The law named options.name. Throws InputError with every fault of options and goal, and where no law of
  /// that name exists.
  std::unique_ptr<Law> make(const LawOptions& options, const ServoGoal& goal) const;

 private:
  std::vector<std::pair<std::string, Factory>> laws_;
};

/// The largest gain lambda (1/s) at which e' = -lambda e stays stable when the command is decided anew
/// `sample_rate_hz` times a second and acts `delay_s` late: with n whole periods of delay (rounded up),
/// e[k+1] = e[k] - lambda dt e[k-n] is stable below lambda dt = 2 sin(pi / (2 (2 n + 1))): 2 without delay, 1
/// with one period, 0.62 with two (Levin and May, "A note on difference-delay equations", Theoretical
/// Population Biology 9, 1976). The controller predicts over the delay, which lifts this limit as long as it
/// knows delay and motion well.
double max_stable_gain_per_s(double sample_rate_hz, double delay_s);

/// Distance of the ball ahead of the axle (X_R, m): every law here is singular exactly where it is 0.
double ahead_of_axle_m(const CameraMount& mount, const Eigen::Vector3d& p_CB);

/// Below this distance ahead of the axle (m) laws give no answer; the controller then turns towards the ball.
inline constexpr double min_ahead_m = 0.02;

}  // namespace ballservo
