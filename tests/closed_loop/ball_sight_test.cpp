// Which of the balls in a picture is the target.
#include "app/experiment/ball_sight.hpp"

#include <gtest/gtest.h>

#include "servo/simulation/rendering/camera_renderer.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

/// What level image takes for the target in the thirtieth picture from the start.
BallMeasurement seen_target(Scenario& scenario) {
  const CameraRenderer renderer(scenario.camera.camera, scenario.world, scenario.camera.sensor);
  const auto colors = std::make_shared<ColorTable>(read_color_file(scenario.colors));
  const auto sight = make_image_sight(scenario.camera.camera, colors, scenario.target_ball(),
                                      scenario.world.balls, scenario.goal(), 0, false);
  std::string rows;
  BallMeasurement measurement;
  for (int frame = 0; frame < 30; ++frame) {
    const double time_s = frame / 30.0;
    const cv::Mat picture =
        renderer.render({{scenario.X_WC({}), time_s}}, 1, static_cast<std::uint64_t>(frame));
    SightInput input;
    input.frame = frame;
    input.time_s = time_s;
    input.picture = &picture;
    measurement = sight->look(input, rows).measurement;
  }
  return measurement;
}

TEST(ImageSight, TakesNoSignOnTheWallForTheBall) {
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

TEST(ImageSight, KnowsHowHighTheTargetIsLifted) {
  Scenario scenario = test::static_ball(3);
  Ball& ball = scenario.world.balls[0];
  ball.position_m = {2.5, 0.2, 0.06};
  const Eigen::Vector3d lifted_m(2.5, 0.2, 0.6);
  ball.motion = WaypointMotion{{{0, lifted_m}}};
  const BallMeasurement seen = seen_target(scenario);
  EXPECT_EQ(seen.state, TrackState::confirmed);
  EXPECT_LT((scenario.X_WC({}) * seen.p_CB - lifted_m).norm(), 0.03);
}

TEST(ImageSight, AMountThatIsBadlyKnownHidesNoBall) {
  for (const char* pitch : {"-0.03", "0.03"}) {
    Scenario scenario = test::static_ball(3, {std::string("believed.pitch_error_rad=") + pitch});
    scenario.world.balls[0].position_m = {4.5, 0.3, 0.06};
    EXPECT_EQ(seen_target(scenario).state, TrackState::confirmed) << pitch;
  }
}

}  // namespace
}  // namespace ballservo
