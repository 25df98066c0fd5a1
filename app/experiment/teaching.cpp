#include "app/experiment/teaching.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "calibration/base/fault.hpp"
#include "servo/simulation/world/collision.hpp"

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

}  // namespace

TaughtTarget teach_target(const Scenario& scenario, const TeachOptions& options) {
  const Scenario there = at_the_goal(scenario);
  check_clear(there);
  SimulatedCamera camera(there, options.seed, options.perception == PerceptionLevel::image,
                         [&there](double time_s) {
                           return RobotTruth{time_s, there.robot.pose, {}};
                         });
  const auto perception = make_perception(there, options.perception, options.seed, options.colors, camera);
  SteppedClock clock;
  std::vector<Eigen::Vector3d> seen;
  for (int frame = 0; frame < options.frames;) {
    if (options.progress) options.progress(frame);
    const auto exposed = camera.take(clock, camera.next_start_s() + there.camera.exposure_s);
    if (!exposed) continue;
    ++frame;
    const BallMeasurement ball = perception->look(*exposed).ball;
    if (ball.state == TrackState::confirmed) seen.push_back(ball.p_CB / there.goal().ball_radius_m);
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

}  // namespace ballservo
