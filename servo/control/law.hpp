// The laws: from where the ball is to how the robot should move.
//
// All laws serve one physical goal: the ball's centre straight ahead of the robot, at a stated distance from
// the axle, in the floor plane. Each derives its own desired features from it.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/base/fault.hpp"
#include "servo/motion/mount.hpp"
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
  /// The same in the robot frame; (distance_m, 0, ball_height_m) where nothing was taught.
  Eigen::Vector3d desired_p_RB() const;
  /// Adds a fault for a distance or radius that is not finite and positive, a height or taught feature that
  /// is not finite, a ball taught behind the camera, and the mount's own.
  void check(FaultList& faults, const std::string& place) const;
};

struct LawOptions {
  std::string name = "cone";  ///< one of law_names()
  double gain_per_s = 2.0;    ///< lambda of the exponential decay that the law asks for: de/dt = -lambda e
};
void declare(OptionVisitor& v, LawOptions& law);

/// What a law asks for, before anybody looks at what the robot can do. Always finite.
struct LawOutput {
  Twist2 twist;
  double error_1 = 0, error_2 = 0;  ///< features less desired features, in the law's own order
};

/// A control law on two features of the ball's centre. Its features must not depend on how the floor is
/// turned.
class Law {
 public:
  virtual ~Law() = default;

  virtual std::string_view name() const = 0;

  /// The twist that lets both errors decay at the law's gain for a ball at p_CB (m) that moves over ground at
  /// v_CB (m/s, in camera axes; feed-forward: e' = J u + L v_CB, u = J^-1 (-lambda e - L v_CB)). Nothing
  /// where the law has no answer: features undefined there, or the ball abeam of the axle or behind it, where
  /// J is singular (each law says where), or a value that is not finite.
  virtual std::optional<LawOutput> command(const Eigen::Vector3d& p_CB, const Eigen::Vector3d& v_CB) = 0;

  /// The two errors alone; nothing where the features are undefined.
  virtual std::optional<Eigen::Vector2d> errors(const Eigen::Vector3d& p_CB) const = 0;

  /// Robot Jacobian J (2 x 2): derivative of the errors by time, per (v, w), for a ball that rests.
  virtual std::optional<Eigen::Matrix2d> robot_jacobian(const Eigen::Vector3d& p_CB) const = 0;

  /// Interaction with the ball's own motion L (2 x 3): derivative of the errors by p_CB.
  virtual std::optional<Eigen::Matrix<double, 2, 3>> ball_jacobian(const Eigen::Vector3d& p_CB) const = 0;
};

/// The twist that lets a law's errors decay at `gain_per_s`: u = J^-1 (-lambda e - L v_CB), by Cramer's rule.
/// Nothing where the features are undefined, the Jacobian is singular, or the twist is not finite.
std::optional<LawOutput> decaying(const Law& law, double gain_per_s, const Eigen::Vector3d& p_CB,
                                  const Eigen::Vector3d& v_CB);

/// The largest gain lambda (1/s) at which e' = -lambda e stays stable when the command is decided anew
/// `sample_rate_hz` times a second and acts `delay_s` late: with n whole periods of delay (rounded up),
/// e[k+1] = e[k]
/// - lambda dt e[k-n] is stable below lambda dt = 2 sin(pi / (2 (2 n + 1))): 2 without delay, 1 with one
/// period, 0.62 with two (Levin and May, "A note on difference-delay equations", Theoretical Population
/// Biology 9, 1976). The controller predicts over the delay, which lifts this limit as long as it knows delay
/// and motion well.
double max_stable_gain_per_s(double sample_rate_hz, double delay_s);

/// The names that `make_law` knows, in the order of the documentation: "cone", "visp", "sphere", "pose".
const std::vector<std::string>& law_names();

/// Throws InputError with every fault of options and goal.
std::unique_ptr<Law> make_law(const LawOptions& options, const ServoGoal& goal);

/// Distance of the ball ahead of the axle (X_R, m): every law here is singular exactly where it is 0.
double ahead_of_axle_m(const CameraMount& mount, const Eigen::Vector3d& p_CB);

/// Below this distance ahead of the axle (m) laws give no answer; the controller then turns towards the ball.
inline constexpr double min_ahead_m = 0.02;

}  // namespace ballservo
