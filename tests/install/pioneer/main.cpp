// ViSP's simulated Pioneer drives to a ball that is only seen, by a law of ViSP's: usage: visp_robot
// red.colors
#include <visp3/robot/vpSimulatorPioneer.h>

#include <cstdio>

#include "../drawn_ball.hpp"
#include "app/loop/image_perception.hpp"
#include "app/loop/loop.hpp"
#include "app/loop/visp/visp_robot.hpp"
#include "calibration/color/color_file.hpp"
#include "servo/features/builtin_laws.hpp"

using namespace ballservo;

// Draws what it would see, thirty times a second, from where ViSP's robot stands.
class MyCamera : public FrameSource {
 public:
  MyCamera(const vpSimulatorPioneer& pioneer, const ServoGoal& goal, const Eigen::Vector3d& p_WB)
      : pioneer_(pioneer), goal_(goal), p_WB_(p_WB) {}

  std::optional<CameraFrame> take(Clock& clock, double until_s) override {
    const double due_s = static_cast<double>(frames_) / 30;
    if (due_s > until_s) return std::nullopt;
    clock.sleep_until(due_s);
    const Eigen::Isometry3d X_WC = X_WR(pose_of(pioneer_)) * goal_.mount.X_RC();
    return CameraFrame{frames_++, due_s, due_s + 0.03,
                       draw_ball(X_WC.inverse() * p_WB_, goal_.ball_radius_m)};
  }

 private:
  const vpSimulatorPioneer& pioneer_;
  ServoGoal goal_;
  Eigen::Vector3d p_WB_;
  long frames_ = 0;
};

int main(int, char** arguments) {
  ControllerOptions options;
  options.latency_s = 0.03;
  options.actuation_delay_s = 0;
  const Eigen::Vector3d p_WB(2.4, 0.5, options.goal.ball_height_m);

  CameraParameters lens;
  lens.size = {640, 480};
  lens.fx_px = lens.fy_px = focal_px;
  lens.cx_px = center_x_px;
  lens.cy_px = center_y_px;
  const auto colors = std::make_shared<ColorTable>(read_color_file(arguments[1]));
  DetectorOptions detector;
  detector.radii.resize(1);
  detector.radii[0].radius_m = options.goal.ball_radius_m;
  ImagePerception perception(Tracker(Detector(std::make_shared<RayTable>(Camera(lens)), colors, detector)),
                             TargetOptions{1, options.goal.mount, options.goal.ball_height_m});

  vpSimulatorPioneer pioneer;
  pioneer.setSamplingTime(1 / options.rate_hz);
  VispRobot robot(pioneer, options.limits, [&pioneer] { return pose_of(pioneer); });
  MyCamera camera(pioneer, options.goal, p_WB);
  Controller controller(options, builtin_laws().make({"visp"}, options.goal));
  SteppedClock clock;
  run_loop({camera, perception, robot, controller}, clock, [](double time_s) { return time_s < 15; });

  const Eigen::Vector2d p_RB = in_robot_frame(pose_of(pioneer), p_WB.head<2>());
  const double range_mm = 1e3 * (p_RB.norm() - options.goal.distance_m);
  const double bearing_deg = 57.29578 * std::atan2(p_RB.y(), p_RB.x());
  std::printf("stands %.2f mm and %.3f degrees off the goal\n", range_mm, bearing_deg);
  return std::abs(range_mm) <= 10 && std::abs(bearing_deg) <= 0.5 ? 0 : 1;
}
