// Which of the balls in a picture is the target.
#include <gtest/gtest.h>

#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

/// What level image takes for the target in the thirtieth picture from the start, by a robot that stands.
BallMeasurement seen_target(const Scenario& scenario) {
  SimulatedCamera camera(scenario, true, [](double time_s) { return RobotTruth{time_s, {}, {}}; });
  const auto colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
  const auto perception = make_perception(scenario, PerceptionLevel::image, colors, camera);
  SteppedClock clock;
  BallMeasurement ball;
  for (int frame = 0; frame < 30; ++frame) ball = perception->look(camera.take(clock, 10).value()).ball;
  return ball;
}

TEST(BallSelection, TakesNoSignOnTheWallForTheBall) {
  Scenario scenario = test::static_ball(3);
  Ball& ball = scenario.world.balls[0];
  ball.position_m = {3.0, 0.2, 0.06};
  Obstacle sign;
  sign.name = "sign";
  sign.shape = DiscShape{0.15};
  sign.center_m = {3.5, -0.4, 0.75};
  sign.yaw_rad = M_PI;
  sign.material = ball.material;
  scenario.world.obstacles = {sign};

  const BallMeasurement both = seen_target(scenario);
  EXPECT_EQ(both.state, TrackState::confirmed);
  EXPECT_LT((scenario.X_WC({}) * both.p_CB - ball.position_m).norm(), 0.03);

  ball.position_m = {-1.5, 0, 0.06};  // behind the robot
  EXPECT_EQ(seen_target(scenario).state, TrackState::none);
}

TEST(BallSelection, KnowsHowHighTheTargetIsLifted) {
  Scenario scenario = test::static_ball(3);
  Ball& ball = scenario.world.balls[0];
  ball.position_m = {2.5, 0.2, 0.06};
  const Eigen::Vector3d lifted_m(2.5, 0.2, 0.6);
  ball.motion = WaypointMotion{{{0, lifted_m}}};
  const BallMeasurement seen = seen_target(scenario);
  EXPECT_EQ(seen.state, TrackState::confirmed);
  EXPECT_LT((scenario.X_WC({}) * seen.p_CB - lifted_m).norm(), 0.03);
}

TEST(BallSelection, AMountThatIsBadlyKnownHidesNoBall) {
  for (const char* pitch : {"-0.03", "0.03"}) {
    Scenario scenario = test::static_ball(3, {std::string("believed.pitch_error_rad=") + pitch});
    scenario.world.balls[0].position_m = {4.5, 0.3, 0.06};
    EXPECT_EQ(seen_target(scenario).state, TrackState::confirmed) << pitch;
  }
}

}  // namespace
}  // namespace ballservo
