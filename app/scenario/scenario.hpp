// A scenario: everything that a simulated run or a rendered picture depends on, read from a strict YAML file.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/scenario/beliefs.hpp"
#include "calibration/base/fault.hpp"
#include "calibration/camera/camera.hpp"
#include "servo/avoidance/avoidance.hpp"
#include "servo/control/law.hpp"
#include "servo/features/builtin_laws.hpp"
#include "servo/motion/camera_mount.hpp"
#include "servo/motion/unicycle.hpp"
#include "servo/simulation/rendering/sensor.hpp"
#include "servo/simulation/robot/camera_faults.hpp"
#include "servo/simulation/robot/geometric_sensors.hpp"
#include "servo/simulation/robot/sonar_ring.hpp"
#include "servo/simulation/robot/unicycle_robot.hpp"
#include "servo/simulation/world/world.hpp"

namespace ballservo {

struct OptionRow;

/// `camera:` of a scenario.
struct CameraSettings {
  std::filesystem::path file;
  Camera camera = long_lens_camera({640, 480});
  CameraMount mount;
  double rate_hz = 30;
  double latency_s = 0.033;  ///< from the middle of an exposure until its measurement arrives
  double exposure_s = 0.004;
  int exposure_steps = 1;  ///< instants of the exposure that are rendered and averaged; 1: no motion blur
  SensorOptions sensor{0.6};
  double white_balance_k = LightCourse{}.white_balance_k;
  std::vector<CameraFault> faults;

  /// From the middle of the picture to its sides.
  double half_view_rad() const { return std::atan(0.5 * camera.size().width_px / camera.focal_px()); }
};

/// `robot:` of a scenario.
struct RobotSettings {
  Pose2 pose;  ///< at time 0
  double actuation_delay_s = 0.05;
  UnicycleLimits limits;
  double acceleration_share =
      1;  ///< the drive's true accelerations over those of `limits`; not known to the robot
  Footprint footprint = pioneer_3dx_footprint;
  OdometryOptions odometry;           ///< exact unless the scenario says otherwise
  std::optional<SonarOptions> sonar;  ///< nothing: the robot has none
  std::vector<SonarFault> sonar_faults;
};

struct Scenario {
  std::filesystem::path file;
  std::uint64_t seed = 0;
  std::string resolved_json;                          ///< the document after `--set` and `vary`, keys sorted
  std::string document_json;                          ///< the same before `vary`: what all seeds share
  std::vector<std::pair<std::string, double>> drawn;  ///< what `vary` drew: key path and value

  double duration_s = 30;
  CameraSettings camera;
  RobotSettings robot;
  std::filesystem::path colors;  ///< empty: none named
  bool fixed_colors = false;     ///< perception from images looks with the colours as they were taught
  World world;
  std::size_t target = 0;  ///< index of the target among world.balls
  double target_distance_m = 0.8;
  std::filesystem::path taught;  ///< of a target taught by showing; empty: by its distance
  std::optional<Eigen::Vector3d> taught_center_over_radius;
  Beliefs believed;
  LawOptions law;
  AvoidanceOptions avoidance;
  double control_rate_hz = 50;
  GeometricSensorOptions geometric;

  const Ball& target_ball() const { return world.balls[target]; }
  /// As the robot believes: its mount and the ball's radius, and the features where they were taught.
  ServoGoal goal() const;
  /// The camera's pose for a robot's pose, the camera turned so far: X_WC = X_WR X_RC.
  Eigen::Isometry3d X_WC(const Pose2& pose, double pan_rad = 0) const;
};

/// Reads a scenario.
///   sets   "key.path=value" each (`--set`), applied first; what they set is not varied
///   seed   draws every entry of `vary`, each from a stream of its own
///   laws   those that `law.name` may name
/// Throws InputError with every fault at once: unknown and duplicate keys, wrong types and units, numbers
/// that are not finite or implausible, a ball inside the robot, an obstacle, a wall or another ball, an
/// obstacle on the robot, an unknown target, a target that could not be seen whole at the goal (with the
/// distances that would do), and whatever is wrong with the camera's file.
Scenario load_scenario(const std::filesystem::path& file, const std::vector<std::string>& sets,
                       std::uint64_t seed, const LawCatalog& laws = builtin_laws());

/// Every key of a scenario.
std::vector<OptionRow> scenario_keys(const LawCatalog& laws = builtin_laws());

}  // namespace ballservo
