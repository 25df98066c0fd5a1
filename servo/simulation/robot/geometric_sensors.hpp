// Perception without pictures, by geometry: where the ball is, exactly or with the error of a fit to its
// outline; and what a camera can say of the floor ahead.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "calibration/camera/camera.hpp"
#include "servo/avoidance/floor_scan.hpp"
#include "servo/control/ball_measurement.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/rendering/truth.hpp"

namespace ballservo {

class OptionVisitor;

/// The sigmas are those of an outline of 20 px radius; of another, r px, they are 20 / r times as large:
/// small outlines err more. A part of the error stays throughout a run: light, shadow and background go on
/// pulling the same way. Law and defaults are measured: root mean square errors of 21 thousand frames, the
/// first 7 s of 120 runs at level image (64 of static_ball.yaml, 24 of obstacles.yaml, 16 of clutter.yaml and
/// of moving_ball.yaml, a quarter of each from seed 101, 201, 401 and 501; whole balls). Times r / 20 they
/// are 0.048 px of the centre from 7 to 12 px, 0.031 to 20 px, 0.036 to 40 px; of the radius 0.038, 0.024 and
/// 0.028. Errors of frames 10 apart correlate by 0.36. Left out are the 0.1 % of frames that err by more than
/// 8 / r px.
struct GeometricSensorOptions {
  bool exact = false;              ///< level `truth`: no noise
  double center_sigma_px = 0.038;  ///< of the outline's centre, along each axis, at 20 px
  double radius_sigma_px = 0.030;  ///< of the outline's radius, at 20 px
  double bias_share = 0.4;         ///< of the variance: what stays the same throughout a run
  double min_visible_fraction = 0.5;
  double min_radius_px = 3.0;  ///< smaller outlines are not found
};
void declare(OptionVisitor& v, GeometricSensorOptions& options);

class GeometricBallSensor {
 public:
  /// All chance is of `seed`.
  GeometricBallSensor(const Camera& camera, const GeometricSensorOptions& options, std::uint64_t seed);

  /// What perception would say of the ball in this frame: `confirmed`, or `none` where its centre lies
  /// outside the picture, too little of it is seen, or it is too small.
  ///
  /// The errors are those of the outline's centre (two normals) and radius (one), each a bias of the seed and
  /// a noise of (seed, frame_index), carried to 3-D: a centre's error of s px turns the ray by s / f, a
  /// radius' error of s px changes the distance by distance * s / r. The covariance says their sum.
  BallMeasurement measure(const BallTruth& truth, double diameter_m, double time_s,
                          std::uint64_t frame_index) const;

 private:
  Camera camera_;
  GeometricSensorOptions options_;
  std::uint64_t seed_;
  Eigen::Vector3d bias_;  // of the centre (two axes) and the radius, in sigmas
};

/// Where the things that stand on the floor begin, and how much of it they hide.
class FloorSensor {
 public:
  /// `world` must outlive it.
  ///   edge_sigma_px   of the place in the picture where floor ends, each ray and frame anew
  ///   ignored         a ball that is known as such, and is floor here
  FloorSensor(const World& world, const Camera& camera, const CameraMount& mount, double reach_m,
              double edge_sigma_px, const std::string& ignored);

  /// The scan of a frame exposed at that time by a robot that is there, as if its camera had not been turned
  /// by `pan_rad`.
  FloorScan scan(const Pose2& robot, double time_s, std::uint64_t seed, std::uint64_t frame,
                 double pan_rad = 0) const;

 private:
  struct Span {
    double from_m, until_m;
  };
  /// A thing on the floor: its outline there, from which height to which.
  struct Thing {
    FloorOutline outline;
    double bottom_m, top_m;
  };
  std::optional<Span> hidden_by(const Thing& thing, const Eigen::Vector2d& apex,
                                const Eigen::Vector2d& ahead) const;
  std::optional<Span> hidden_by(const Ball& ball, double time_s, const Eigen::Vector2d& apex,
                                const Eigen::Vector2d& ahead) const;
  double to_wall_m(const Eigen::Vector2d& apex, const Eigen::Vector2d& ahead) const;

  const World& world_;
  CameraMount mount_;
  FloorFan fan_;
  double edge_sigma_px_;
  std::string ignored_;
  std::vector<Thing> things_;
};

}  // namespace ballservo
