// A camera that turns on its robot.
#include <gtest/gtest.h>

#include <cmath>

#include "servo/control/gaze.hpp"
#include "tests/closed_loop/closed_loop_run.hpp"

namespace ballservo {
namespace {

constexpr double delay_s = 0.05, dt_s = 0.02;
const PanLimits pan{1.57};

TEST(Pan, StopsAtItsStopsAndComesBack) {
  SimulatedPan joint(pan, delay_s);
  joint.command(100);
  EXPECT_EQ(joint.advance_to(delay_s).angle_rad, 0);
  EXPECT_NEAR(joint.advance_to(0.5).speed_radps, pan.speed_max_radps, 1e-9);
  const PanMotion stopped = joint.advance_to(5);
  EXPECT_EQ(stopped.angle_rad, pan.max_rad);
  EXPECT_EQ(stopped.speed_radps, 0);
  joint.command(-1);
  EXPECT_LT(joint.advance_to(6).angle_rad, pan.max_rad - 0.5);
}

TEST(Pan, KeepsTheBallInTheMiddleWhileTheRobotDrivesPast) {
  const CameraMount mount{0.10, 0.28, 0.21, pan};
  Gaze gaze(mount, 0, delay_s, 64);
  SimulatedPan joint(pan, delay_s);
  const Eigen::Vector2d p_WB(2.0, 0.8);
  const Twist2 twist{0.4, -0.2};
  double worst_rad = 0, largest_rad = 0;
  for (int k = 0; k < 250; ++k) {
    const double time_s = k * dt_s;
    const auto azimuth_at = [&](double then_s) {
      const Eigen::Vector2d p =
          in_robot_frame(integrate({}, twist, then_s), p_WB) - Eigen::Vector2d(mount.forward_m, 0);
      return std::atan2(p.y(), p.x());
    };
    const PanMotion now = joint.advance_to(time_s);
    const Eigen::Vector2d p_RB = in_robot_frame(integrate({}, twist, time_s + delay_s), p_WB);
    joint.command(gaze.follow(time_s, now, {p_RB, {0, 0}}, twist));
    EXPECT_LE(std::abs(now.angle_rad), pan.max_rad);
    largest_rad = std::max(largest_rad, now.angle_rad);
    if (time_s > 1 && azimuth_at(time_s) < pan.max_rad - 0.05)
      worst_rad = std::max(worst_rad, std::abs(now.angle_rad - azimuth_at(time_s)));
  }
  EXPECT_LT(worst_rad, 0.02);
  EXPECT_NEAR(largest_rad, pan.max_rad, 0.02) << "it follows the ball as far as it goes";
}

TEST(Pan, ShowsTheBallToARobotThatDrivesAroundThings) {
  double fixed_s = 0, panned_s = 0;
  for (std::uint64_t seed = 200; seed < 212; ++seed) {
    for (double* out_of_view_s : {&fixed_s, &panned_s}) {
      const std::string max_rad = out_of_view_s == &fixed_s ? "0" : "1.57";
      const Scenario scenario = load_scenario(test::project_data_dir() / "scenarios" / "obstacles.yaml",
                                              {"camera.mount.pan.max_rad=" + max_rad}, seed);
      const RunSummary s = test::run(scenario, PerceptionLevel::geometric).summary;
      EXPECT_EQ(s.outcome, Outcome::reached) << seed << " " << max_rad << ": " << s.outcome_text;
      *out_of_view_s += s.out_of_view_s;
    }
  }
  EXPECT_LT(panned_s, 0.5 * fixed_s);
}

TEST(Pan, PicturesOfATurnedCameraPutTheBallWhereItIs) {
  const Scenario scenario = test::static_ball(1, {"camera.mount.pan.max_rad=1.57", "robot.pose.yaw_rad=-0.8",
                                                  "robot.limits.w_max_radps=0.2", "duration_s=3"});
  const RunRecord run = test::run(scenario, PerceptionLevel::image);
  int aside = 0;
  for (const FrameRecord& frame : run.frames) {
    if (frame.measurement.state != TrackState::confirmed) continue;
    const auto step = std::find_if(run.steps.begin(), run.steps.end(),
                                   [&](const StepRecord& s) { return s.time_s >= frame.time_s; });
    ASSERT_NE(step, run.steps.end());
    // What a pan taken wrongly would turn is the direction; at 3 m a pixel is 10 cm of range.
    const Eigen::Isometry3d X_WC = scenario.X_WC(step->pose, frame.measurement.pan_rad);
    const Eigen::Vector3d seen = X_WC.linear() * frame.measurement.p_CB;
    const Eigen::Vector3d there = scenario.target_ball().position_m - X_WC.translation();
    EXPECT_LT(std::acos(std::min(1.0, seen.normalized().dot(there.normalized()))), 0.01) << frame.time_s;
    aside += std::abs(frame.measurement.pan_rad) > 0.3 ? 1 : 0;
  }
  EXPECT_GT(aside, 20);
}

}  // namespace
}  // namespace ballservo
