#include "app/experiment/taught_target.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "app/experiment/run_camera.hpp"
#include "calibration/files/fault.hpp"
#include "calibration/files/numbers.hpp"
#include "servo/simulation/collision.hpp"

namespace ballservo {
namespace {

/// The scenario with its robot at the goal and its ball at rest.
Scenario at_the_goal(const Scenario& scenario) {
  Scenario there = scenario;
  Ball& ball = there.world.balls[there.target];
  ball.position_m = ball.p_WB(0);
  ball.motion = StaticMotion{};
  const Pose2 start = scenario.robot.pose;
  const Eigen::Vector2d p_WB = ball.position_m.head<2>();
  const Eigen::Vector2d way = p_WB - Eigen::Vector2d(start.x_m, start.y_m);
  const double yaw_rad = std::atan2(way.y(), way.x());
  const Eigen::Vector2d goal =
      p_WB - scenario.target_distance_m * Eigen::Vector2d(std::cos(yaw_rad), std::sin(yaw_rad));
  there.robot.pose = {goal.x(), goal.y(), yaw_rad};
  return there;
}

void check_clear(const Scenario& there) {
  const ContactReport contacts = find_contacts(there.world, there.robot.footprint, there.robot.pose, 0);
  if (!contacts.collision() && !contacts.ball_contact()) return;
  throw Refusal(fmt::format(
      "cannot teach: at the goal, ({:.2f}, {:.2f}) m, the robot would touch {}; move it, or start the robot "
      "elsewhere (--set robot.pose.x_m=...)",
      there.robot.pose.x_m, there.robot.pose.y_m,
      contacts.collision() ? contacts.nearest : contacts.nearest_ball));
}

Eigen::Vector3d read_vector(YamlNode node, const std::string& key, const NumberRange& range) {
  const std::vector<double> v = node.numbers(key, range, 3);
  return v.size() == 3 ? Eigen::Vector3d(v[0], v[1], v[2]) : Eigen::Vector3d::Zero();
}

std::string vector_text(const Eigen::Vector3d& v) {
  return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]";
}

}  // namespace

TaughtTarget teach_target(const Scenario& scenario, const TeachOptions& options) {
  const Scenario there = at_the_goal(scenario);
  check_clear(there);
  RunOptions run;
  run.perception = options.perception;
  run.seed = options.seed;
  run.colors = options.colors;
  RunCamera camera(there, run);
  const double radius_m = there.goal().ball_radius_m;
  std::vector<Eigen::Vector3d> seen;
  std::string rows;
  for (int frame = 0; frame < options.frames;) {
    const auto exposed = camera.expose(there.robot.pose, rows);
    if (!exposed) continue;
    ++frame;
    const BallMeasurement& measurement = exposed->record.measurement;
    if (measurement.state == TrackState::confirmed) seen.push_back(measurement.p_CB / radius_m);
  }
  if (2 * seen.size() < static_cast<std::size_t>(options.frames)) {
    throw Refusal(
        fmt::format("nothing taught: standing at the goal, the robot was sure of ball {} in {} of {} frames "
                    "only; look at "
                    "what the camera sees there (render), at the colours, and at what hides the ball",
                    there.target_ball().name, seen.size(), options.frames));
  }
  TaughtTarget target;
  target.ball = there.target_ball().name;
  target.frames = static_cast<int>(seen.size());
  target.distance_m = scenario.target_distance_m;
  for (const Eigen::Vector3d& each : seen) target.center_over_radius += each / target.frames;
  Eigen::Array3d variance = Eigen::Array3d::Zero();
  for (const Eigen::Vector3d& each : seen) {
    variance += (each - target.center_over_radius).array().square() / std::max(1, target.frames - 1);
  }
  target.sigma = (variance / target.frames).sqrt();
  return target;
}

std::string taught_target_yaml(const TaughtTarget& target) {
  return "# What the robot saw of the ball when it stood at the goal. In a scenario: target: {ball: " +
         target.ball +
         ", taught: THIS_FILE}\n"
         "ball: " +
         target.ball +
         "\n"
         "center_over_radius: " +
         vector_text(target.center_over_radius) +
         "   # the ball's centre in the camera frame (x right, y down, z forward), in radii\n"
         "sigma: " +
         vector_text(target.sigma) +
         "   # standard deviations, of the mean over the frames\n"
         "frames: " +
         std::to_string(target.frames) +
         "\n"
         "distance_m: " +
         number_text(target.distance_m) +
         "   # where it stood, axle to the ball's centre: nothing but the errors in summaries depends on "
         "it\n";
}

TaughtTarget read_taught_target(const std::filesystem::path& file) {
  StrictYaml yaml = StrictYaml::from_file(file);
  YamlNode root = yaml.root();
  TaughtTarget target;
  target.ball = root.text("ball");
  target.center_over_radius =
      read_vector(root, "center_over_radius", NumberRange::within(-1e4, 1e4, "radii"));
  if (root.has("center_over_radius") && !(target.center_over_radius.z() > 1)) {
    root.fault("center_over_radius", vector_text(target.center_over_radius),
               "a ball before the camera: the third number above 1");
  }
  target.sigma = read_vector(root, "sigma", NumberRange::within(0, 1e4, "radii"));
  target.frames = static_cast<int>(root.integer("frames", 1, 1000000));
  target.distance_m = root.number("distance_m", {0, 20, true, false, "m"});
  yaml.finish();
  return target;
}

}  // namespace ballservo
