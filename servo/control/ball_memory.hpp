// What the controller knows of the ball: the frames that have arrived, and the filter behind them, which says
// where the ball is between and behind the camera's frames.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>

#include "servo/control/ball_measurement.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/motion/motion_history.hpp"

namespace ballservo {

/// The ball as predicted: O is the odometry's frame, in which the robot's pose is X_OR.
struct TargetEstimate {
  Eigen::Vector3d p_OB{0, 0, 0};  ///< m, by odometry's metre
  Eigen::Vector2d v_OB{0, 0};     ///< in the floor plane (m/s); 0 where the sightings do not support a speed
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of p_OB
  double scale = 1;  ///< sightings put the ball so many times as far from the camera as it is
};

/// A Kalman filter of constant velocity (Bar-Shalom, Li and Kirubarajan, "Estimation with Applications to
/// Tracking and Navigation", 6.2) in the floor plane, constant height. Sightings come late, with their own
/// time stamps, and with the robot's pose at that time; duplicates and backward stamps are ignored. Allocates
/// nothing.
///
/// A wrong diameter or focal length puts a ball at scale * p_CB: one that rests then seems to move whenever
/// the robot does. With the camera's centre c_OC in O, a sighting p_CB is R_CO (scale * p_OB - scale * c_OC),
/// which is linear in the state (scale * p_OB, scale * v_OB, scale).
class TargetFilter {
 public:
  static constexpr double never = -std::numeric_limits<double>::infinity();
  static constexpr double greatest_scale = 5;  ///< and 1 / 5 the least that is reckoned with

  /// `scale_sigma`: what is not known of the scale, which is 1 at first; 0: it is 1.
  explicit TargetFilter(const CameraMount& mount, double scale_sigma = 0)
      : mount_(mount), scale_sigma_(scale_sigma) {
    covariance_(5, 5) = scale_sigma * scale_sigma;
  }

  /// So many sightings in a row far from the prediction, and the filter starts anew there.
  static constexpr int doubts_to_restart = 3;

  enum class Update { accepted, started, doubted, ignored };
  /// `pose` is the odometry's at measurement.time_s. Measurements that are no sightings, not finite, or of an
  /// impossible covariance are ignored.
  Update update(const BallMeasurement& measurement, const Pose2& pose);

  /// The ball at time_s, not before the last sighting; nothing before the first.
  std::optional<TargetEstimate> predict(double time_s) const;

  double last_time_s() const { return time_s_; }  ///< of the newest sighting taken, -inf before the first

 private:
  using State = Eigen::Matrix<double, 6, 1>;  // x, y, z, vx, vy in O, all times the scale; the scale
  using Covariance = Eigen::Matrix<double, 6, 6>;
  void propagate(double dt_s, State& state, Covariance& covariance) const;
  /// p_OB: as sighted, by scale 1; c_OC: of the camera.
  void start(double time_s, const Eigen::Vector3d& p_OB, const Eigen::Matrix3d& covariance_m2,
             const Eigen::Vector3d& c_OC);

  CameraMount mount_;
  double scale_sigma_;
  int doubts_ = 0;
  double time_s_ = never, stamp_s_ = never;  // of the state; of the newest measurement looked at
  State state_ = State::Unit(5);
  Covariance covariance_ = Covariance::Zero();
};

/// Frames wait in an inbox until a control step takes them in. Allocates nothing.
class BallMemory {
 public:
  BallMemory(const CameraMount& mount, double scale_sigma) : filter_(mount, scale_sigma) {}

  /// A frame that arrived at that time.
  void see(const BallMeasurement& measurement, double arrived_s);
  /// The first frame is awaited from here on.
  void start(double time_s) { frame_s_ = frame_arrived_s_ = time_s; }
  /// Reads the inbox; duplicate frames, backward ones and those of the future are left out.
  void take_in(double time_s, const PoseHistory& poses);
  void clear_inbox() { inbox_count_ = 0; }
  /// The track is to be confirmed anew.
  void doubt() { confirmed_ = 0; }

  /// Where the ball is at time_s; a ball out of sight is not taken to move on for ever. Nothing before the
  /// first sighting.
  std::optional<TargetEstimate> predict(double time_s) const;

  /// Whether something that is not finite was taken in last.
  bool nonsense() const { return nonsense_; }
  double frame_s() const { return frame_s_; }                  ///< exposure of the newest frame
  double frame_arrived_s() const { return frame_arrived_s_; }  ///< when it arrived
  double sighting_s() const { return sighting_s_; }        ///< exposure of the newest sighting; -inf: none
  int confirmed() const { return confirmed_; }             ///< confirmed sightings in a row
  TrackState track_state() const { return track_state_; }  ///< of the newest frame

 private:
  static constexpr double never = TargetFilter::never;
  struct Arrival {
    BallMeasurement frame;
    double arrived_s = 0;
  };

  TargetFilter filter_;
  std::array<Arrival, 16> inbox_;
  std::size_t inbox_count_ = 0;
  double frame_s_ = never, frame_arrived_s_ = never, sighting_s_ = never;
  TrackState track_state_ = TrackState::none;
  int confirmed_ = 0;
  bool nonsense_ = false;
};

}  // namespace ballservo
