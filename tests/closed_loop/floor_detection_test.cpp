// The floor as pictures show it beside the floor as it is.
#include "app/loop/floor_detection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "servo/avoidance/floor_scan.hpp"
#include "servo/simulation/rendering/camera_renderer.hpp"
#include "servo/simulation/robot/geometric_sensors.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

struct Agreement {
  int both = 0, bare = 0, missed = 0, false_alarms = 0;
  std::vector<double> errors_px;
};

/// Stands at the start, then half a metre further on, and looks.
void compare(std::uint64_t seed, Agreement& agreement) {
  const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "clutter.yaml", {}, seed);
  const CameraSettings& camera = scenario.camera;
  CameraRenderer renderer(camera.camera, scenario.world, camera.sensor);
  FloorDetection detection(camera.camera, camera.mount, scenario.avoidance.grid.start_clear_m);
  const FloorSensor exact(scenario.world, camera.camera, camera.mount, floor_reach_m, 0.0,
                          scenario.target_ball().name);
  const FloorFan fan(camera.camera, camera.mount, floor_reach_m);
  for (int frame = 0; frame < 2; ++frame) {
    Pose2 pose = scenario.robot.pose;
    pose.x_m += 0.5 * frame * std::cos(pose.yaw_rad);
    pose.y_m += 0.5 * frame * std::sin(pose.yaw_rad);
    const CameraView view{scenario.X_WC(pose), 0};
    const cv::Mat picture =
        expose(renderer.radiance({view}), camera.sensor, seed, static_cast<std::uint64_t>(frame));
    const auto ball = ball_truth(camera.camera, scenario.world, view, scenario.target).outline;
    const FloorScan seen = detection.look(picture, 0, ball),
                    truth = exact.scan(pose, 0, seed, static_cast<std::uint64_t>(frame));
    ASSERT_EQ(seen.count, truth.count);
    for (std::size_t k = 0; k < seen.count; ++k) {
      const FloorRay &a = seen.rays[k], &b = truth.rays[k];
      ASSERT_EQ(a.bearing_rad, b.bearing_rad);
      const bool stands = b.clear_m < fan.reach_m(), claimed = a.clear_m < fan.reach_m();
      ++(stands    ? claimed ? agreement.both : agreement.missed
         : claimed ? agreement.false_alarms
                   : agreement.bare);
      if (stands && claimed)
        agreement.errors_px.push_back((a.clear_m - b.clear_m) / fan.metres_per_pixel(b.clear_m));
    }
  }
}

TEST(FloorDetection, PicturesShowWhatGeometrySays) {
  Agreement agreement;
  for (std::uint64_t seed = 9000; seed < 9040; ++seed) compare(seed, agreement);
  const int stands = agreement.both + agreement.missed, bare = agreement.bare + agreement.false_alarms;
  ASSERT_GE(stands, 500);
  EXPECT_LE(agreement.missed, 0.08 * stands) << "of " << stands;
  EXPECT_LE(agreement.false_alarms, 0.02 * bare) << "of " << bare;
  std::vector<double>& errors = agreement.errors_px;
  std::sort(errors.begin(), errors.end());
  const auto share = [&errors](double p) {
    return errors[static_cast<std::size_t>(p * static_cast<double>(errors.size() - 1))];
  };
  RecordProperty("missed_of", std::to_string(agreement.missed) + " of " + std::to_string(stands));
  RecordProperty("false_alarms", agreement.false_alarms);
  RecordProperty("p5_p50_p95_px", std::to_string(share(0.05)) + " " + std::to_string(share(0.5)) + " " +
                                      std::to_string(share(0.95)));
  EXPECT_NEAR(share(0.5), 0, 2.5) << "px, towards the robot negative";
  EXPECT_GT(share(0.05), -8);
  EXPECT_LT(share(0.95), 3);
}

// In the loop: a low step across the way, into which the robot drives without (see Obstacles.LowThings...).
TEST(FloorDetection, ALowStepThatNoSonarHearsIsNotDrivenInto) {
  const std::vector<std::string> sets{
      "obstacles=[{type: box, name: step, position: {x_m: 1.5, y_m: 0}, size: {x_m: 0.2, y_m: 3, z_m: "
      "0.05}}]",
      "balls.0.position.x_m=4", "balls.0.position.y_m=0", "robot.pose.yaw_rad=0", "duration_s=4"};
  const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "obstacles.yaml", sets, 0);
  for (const PerceptionLevel level : {PerceptionLevel::geometric, PerceptionLevel::image}) {
    const RunSummary s = test::run(scenario, level).summary;
    EXPECT_NE(s.outcome, Outcome::collision) << s.outcome_text;
    EXPECT_GT(s.min_clearance_m, 0.0);
    EXPECT_LT(s.min_clearance_m, 0.9) << "it drives up to it";
  }
}

}  // namespace
}  // namespace ballservo
